// Another monitor's coming and going changes nothing.
#include "experiment/app/monitor_watch.h"

namespace equilux {

void MonitorWatch::follow(const void* monitor, const std::string& name) {
  monitor_ = monitor;
  name_ = name;
  is_lost_ = false;
}

bool MonitorWatch::disconnect(const void* monitor) {
  if (is_lost_ || monitor != monitor_) return false;
  monitor_ = nullptr;
  return is_lost_ = true;
}

bool MonitorWatch::connect(const void* monitor, const std::string& name) {
  if (!is_lost_ || name != name_) return false;
  monitor_ = monitor;
  is_lost_ = false;
  return true;
}

}  // namespace equilux
