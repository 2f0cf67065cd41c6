// A monitor that is unplugged and comes back, among others.
#include "experiment/app/monitor_watch.h"

#include <gtest/gtest.h>

namespace equilux {
namespace {

// What the window system knows monitors by: addresses alone count.
const int kOurs = 0, kOther = 0, kAgain = 0;

MonitorWatch follow_ours() {
  MonitorWatch watch;
  watch.follow(&kOurs, "DP-1");
  return watch;
}

TEST(MonitorWatchTest, AMonitorIsLostUntilOneOfItsNameIsConnected) {
  MonitorWatch watch = follow_ours();
  EXPECT_FALSE(watch.is_lost());
  EXPECT_TRUE(watch.disconnect(&kOurs));
  EXPECT_TRUE(watch.is_lost());
  EXPECT_FALSE(watch.connect(&kOther, "HDMI-1"));
  EXPECT_TRUE(watch.is_lost()) << "another one does not do";
  EXPECT_TRUE(watch.connect(&kAgain, "DP-1"));
  EXPECT_FALSE(watch.is_lost());
  EXPECT_EQ(watch.name(), "DP-1");
}

TEST(MonitorWatchTest, OtherMonitorsComeAndGo) {
  MonitorWatch watch = follow_ours();
  EXPECT_FALSE(watch.disconnect(&kOther));
  EXPECT_FALSE(watch.is_lost());
  EXPECT_FALSE(watch.connect(&kOther, "DP-1")) << "a second one of this name, while ours is there";
  EXPECT_TRUE(watch.disconnect(&kOurs));
  EXPECT_FALSE(watch.disconnect(&kOther));
  EXPECT_TRUE(watch.is_lost());
}

TEST(MonitorWatchTest, WhatCameBackCanBeLostAgain) {
  MonitorWatch watch = follow_ours();
  watch.disconnect(&kOurs);
  watch.connect(&kAgain, "DP-1");
  EXPECT_FALSE(watch.disconnect(&kOurs)) << "its old address is nobody's any more";
  EXPECT_FALSE(watch.is_lost());
  EXPECT_TRUE(watch.disconnect(&kAgain));
  EXPECT_TRUE(watch.is_lost());
}

}  // namespace
}  // namespace equilux
