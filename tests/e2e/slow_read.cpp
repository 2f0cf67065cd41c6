// Loaded before the C library into a program under test: while the file EQUILUX_SLOW_WHILE stands there, each
// PNG file is opened EQUILUX_SLOW_MS late.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <string_view>
#include <thread>
#include <unistd.h>

extern "C" FILE* fopen64(const char* path, const char* mode) {
  using Open = FILE* (*)(const char*, const char*);
  static const auto open = reinterpret_cast<Open>(::dlsym(RTLD_NEXT, "fopen64"));
  const char* file = std::getenv("EQUILUX_SLOW_WHILE");
  const char* late_ms = std::getenv("EQUILUX_SLOW_MS");
  if (file && late_ms && std::string_view(path).ends_with(".png") && ::access(file, F_OK) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(std::atoi(late_ms)));
  return open(path, mode);
}
