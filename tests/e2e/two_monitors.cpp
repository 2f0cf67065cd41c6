// The server's configuration, and xrandr as a user would call it.
#include "tests/e2e/two_monitors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <stdexcept>

#include "base/files.h"

namespace equilux {
namespace {

constexpr const char* kConfiguration = R"(
Section "ServerFlags"
  Option "AutoAddDevices" "false"
  Option "AutoAddGPU" "false"
  Option "DontVTSwitch" "true"
EndSection
Section "Device"
  Identifier "card"
  Driver "dummy"
  VideoRam 65536
EndSection
Section "Monitor"
  Identifier "monitor"
  HorizSync 5-1000
  VertRefresh 5-200
EndSection
Section "Screen"
  Identifier "screen"
  Device "card"
  Monitor "monitor"
  DefaultDepth 24
  SubSection "Display"
    Depth 24
    Virtual 2304 1024
    Modes "1280x1024" "1024x768"
  EndSubSection
EndSection
)";

std::vector<std::string> start_with(const std::filesystem::path& folder) {
  const auto configuration = folder / "monitors.conf";
  save_text(configuration, kConfiguration);
  return {"Xorg",
          "-displayfd",
          "3",
          "-config",
          configuration.string(),
          "-logfile",
          (folder / "xorg.log").string(),
          "-nolisten",
          "tcp",
          "-noreset",
          "-sharevts",
          "-novtswitch"};
}

void run(const std::vector<std::string>& command) {
  ChildProcess program(command);
  if (program.wait() != 0)
    throw std::runtime_error(fmt::format("{}: {}", fmt::join(command, " "), program.read_output()));
}

std::string name_mode(const PlacedMonitor& monitor) {
  return fmt::format("{}x{}", monitor.width, monitor.height);
}

}  // namespace

TwoMonitors::TwoMonitors(const std::filesystem::path& folder)
    : XDisplay(start_with(folder), kFirstMonitor.width, kFirstMonitor.height) {}

void TwoMonitors::connect() const {
  arrange({"--output", kFirstMonitor.name, "--primary", "--mode", name_mode(kFirstMonitor)});
  arrange({"--addmode", kSecondMonitor.name, name_mode(kSecondMonitor)});
  plug_in(kFirstMonitor, kSecondMonitor);
}

void TwoMonitors::look_at_monitor(const PlacedMonitor& monitor) {
  look_at(monitor.x, monitor.y, monitor.width, monitor.height);
}

void TwoMonitors::unplug(const PlacedMonitor& monitor) const { arrange({"--output", monitor.name, "--off"}); }

void TwoMonitors::plug_in(const PlacedMonitor& first, const PlacedMonitor& second) const {
  std::vector<std::string> arguments;
  for (const PlacedMonitor& monitor : {first, second}) {
    arguments.insert(arguments.end(), {"--output", monitor.name, "--mode", name_mode(monitor), "--pos",
                                       fmt::format("{}x{}", monitor.x, monitor.y)});
  }
  arrange(arguments);
}

void TwoMonitors::set_gamma(const PlacedMonitor& monitor, const std::string& gamma) const {
  arrange({"--output", monitor.name, "--gamma", gamma});
}

// The desktop keeps its size, so that pictures of any part of it can be taken. That a monitor came or went
// the server notices when it is asked to look.
void TwoMonitors::arrange(const std::vector<std::string>& arguments) const {
  std::vector<std::string> command{"xrandr", "--display", name(), "--fb",
                                   fmt::format("{}x{}", kDesktopWidth, kDesktopHeight)};
  command.insert(command.end(), arguments.begin(), arguments.end());
  run(command);
  run({"xrandr", "--display", name(), "--query"});
}

}  // namespace equilux
