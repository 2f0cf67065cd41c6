// Loaded before the window library into a program under test: while the file EQUILUX_SLOW_WHILE stands there,
// each frame comes EQUILUX_SLOW_MS late.
#include <chrono>
#include <cstdlib>
#include <dlfcn.h>
#include <thread>
#include <unistd.h>

struct GLFWwindow;

extern "C" void glfwSwapBuffers(GLFWwindow* window) {
  using Swap = void (*)(GLFWwindow*);
  static const auto swap = reinterpret_cast<Swap>(::dlsym(RTLD_NEXT, "glfwSwapBuffers"));
  const char* file = std::getenv("EQUILUX_SLOW_WHILE");
  const char* late_ms = std::getenv("EQUILUX_SLOW_MS");
  if (file && late_ms && ::access(file, F_OK) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(std::atoi(late_ms)));
  swap(window);
}
