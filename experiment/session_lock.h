// One program at a time runs a session.
#pragma once

#include <filesystem>
#include <string>

namespace equilux {

/// Held from the moment a participant's session begins or goes on until it is left; the system lets go of it
/// however the program ends. It is on an empty file beside the log, of which every session has a byte of its
/// own: sessions of several participants may run at once, and who reads the log never meets it.
class SessionLock {
 public:
  /// `session` tells which one, by the same words in every program. errors: StoreError where the file cannot
  /// be made, or its file system has no locks
  SessionLock(const std::filesystem::path& log, const std::string& session);
  ~SessionLock();
  SessionLock(SessionLock&& other) noexcept;
  SessionLock& operator=(SessionLock&& other) noexcept;

  /// Somebody else holds it.
  bool is_busy() const { return is_busy_; }

  /// Whether somebody holds it; makes no file.
  static bool is_held(const std::filesystem::path& log, const std::string& session);

 private:
  int descriptor_ = -1;
  bool is_busy_ = false;
};

}  // namespace equilux
