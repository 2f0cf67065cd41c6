// A real program in a process of its own, to be read from, limited and killed.
#pragma once

#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <optional>
#include <poll.h>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "base/error.h"

namespace equilux {

struct ChildResult {
  int exit_code = -1;  ///< -1: ended by a signal
  int signal = 0;
  std::string out;  ///< what was not read before
  std::string err;
};

class Child {
 public:
  /// `arguments` without the program's name. units of the limit: bytes
  Child(const std::string& program, const std::vector<std::string>& arguments,
        std::optional<rlim_t> file_size_limit = std::nullopt) {
    int out[2], err[2];
    EQ_CHECK(::pipe2(out, O_CLOEXEC) == 0 && ::pipe2(err, O_CLOEXEC) == 0);
    ::fcntl(out[1], F_SETPIPE_SZ, 4096);  // so that the program cannot run far ahead of its reader
    pid_ = ::fork();
    EQ_CHECK(pid_ >= 0);
    if (pid_ == 0) become(program, arguments, file_size_limit, out[1], err[1]);
    ::close(out[1]);
    ::close(err[1]);
    out_ = ::fdopen(out[0], "r");
    std::setvbuf(out_, nullptr, _IONBF, 0);  // so that what is ready is all in the pipe
    err_ = ::fdopen(err[0], "r");
  }
  ~Child() {
    if (pid_ > 0) {
      kill();
      wait();
    }
    std::fclose(out_);
    std::fclose(err_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// The next whole line of standard output, without its end; empty at the end of the file.
  std::optional<std::string> read_line() {
    std::string line;
    for (int c = std::fgetc(out_); c != EOF; c = std::fgetc(out_)) {
      if (c == '\n') return line;
      line += static_cast<char>(c);
    }
    return std::nullopt;
  }

  /// The next line if the program has written one. It writes each line at once.
  std::optional<std::string> read_ready_line() {
    pollfd ready{::fileno(out_), POLLIN, 0};
    if (::poll(&ready, 1, 0) != 1 || (ready.revents & POLLIN) == 0) return std::nullopt;
    return read_line();
  }

  /// Halts the program where it is and returns when it stands; false if it has ended.
  bool stop() {
    ::kill(pid_, SIGSTOP);
    siginfo_t info{};
    EQ_CHECK(::waitid(P_PID, static_cast<id_t>(pid_), &info, WSTOPPED | WEXITED | WNOWAIT) == 0);
    return info.si_code == CLD_STOPPED;
  }
  bool runs() {
    siginfo_t info{};
    EQ_CHECK(::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0);
    return info.si_pid == 0;
  }
  void go_on() { ::kill(pid_, SIGCONT); }
  void kill() { ::kill(pid_, SIGKILL); }

  ChildResult wait() {
    ChildResult result;
    result.out = read_rest(out_);
    result.err = read_rest(err_);
    int status = 0;
    EQ_CHECK(::waitpid(pid_, &status, 0) == pid_);
    pid_ = -1;
    if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
    return result;
  }

 private:
  [[noreturn]] static void become(const std::string& program, const std::vector<std::string>& arguments,
                                  std::optional<rlim_t> file_size_limit, int out, int err) {
    ::dup2(out, STDOUT_FILENO);
    ::dup2(err, STDERR_FILENO);
    if (file_size_limit) {
      const rlimit limit{*file_size_limit, *file_size_limit};
      ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    std::vector<char*> words = {const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    ::execv(program.c_str(), words.data());
    ::_exit(127);
  }
  static std::string read_rest(std::FILE* file) {
    std::string text;
    for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
    return text;
  }

  pid_t pid_ = -1;
  std::FILE* out_ = nullptr;
  std::FILE* err_ = nullptr;
};

inline const std::string kSessionProgram = EQUILUX_BIN_DIR "/equilux-session";

inline ChildResult run_session_program(const std::vector<std::string>& arguments) {
  return Child(kSessionProgram, arguments).wait();
}

}  // namespace equilux
