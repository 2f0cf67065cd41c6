// The one try around each main.
#include "base/program.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <unistd.h>

#include "base/error.h"

namespace equilux {
namespace {

char interrupted_text[256];

// Files get their names when they are whole, so there is nothing to clean up. Ends by the signal itself, so
// that a shell knows.
void leave(int signal) {
  [[maybe_unused]] const auto written = write(STDERR_FILENO, interrupted_text, std::strlen(interrupted_text));
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void tell_of_interruption(const std::string& name) {
  std::snprintf(interrupted_text, sizeof interrupted_text,
                "\n%s: interrupted; what was finished until then is kept\n", name.c_str());
  for (const int signal : {SIGINT, SIGTERM}) {
    // Whoever started it in the background may have had it ignored.
    if (std::signal(signal, leave) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

// Seconds since 1970 of such a time.
double parse_utc(const std::string& text) {
  std::tm utc{};
  double seconds = 0;
  if (std::sscanf(text.c_str(), "%4d-%2d-%2dT%2d:%2d:%lfZ", &utc.tm_year, &utc.tm_mon, &utc.tm_mday,
                  &utc.tm_hour, &utc.tm_min, &seconds) != 6)
    throw InputError("UTC", "", "a time such as 2026-01-31T12:00:00.000Z", text);
  utc.tm_year -= 1900;
  utc.tm_mon -= 1;
  return static_cast<double>(timegm(&utc)) + seconds;
}

}  // namespace

int run_program(const std::string& name, const std::function<int()>& body) {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    fmt::print(stderr, "{}: this build needs a processor with AVX2 and FMA (x86-64-v3)\n", name);
    return kExitError;
  }
  tell_of_interruption(name);
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on file size then fails a write, as a full disk does
  try {
    return body();
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "{}: out of memory\n", name);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
  }
  return kExitError;
}

std::string format_utc_now() {
  const auto now = std::chrono::system_clock::now();
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", utc.tm_year + 1900, utc.tm_mon + 1,
                     utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec, milliseconds);
}

double count_hours(const std::string& from_utc, const std::string& to_utc) {
  return (parse_utc(to_utc) - parse_utc(from_utc)) / 3600;
}

std::string find_host_name() {
  char name[256] = {};
  ::gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace equilux
