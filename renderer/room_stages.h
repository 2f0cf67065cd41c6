// Stages of a room on disk until its references are whole: what a kill costs is the stage that was being
// made.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/stage_bytes.h"

namespace equilux {

/// What a StageWriter wrote of one value. Empty where it is damaged, or `is_sound` of its type finds that it
/// cannot be of pictures of this size.
template <typename T>
std::optional<T> parse_stage(std::string_view bytes, PixelSize size, const std::string& source) {
  T value;
  try {  // of a file that may be anybody's: the boundary to making it again
    StageReader reader(bytes, size, source);
    reader.read(value);
    reader.expect_end();
  } catch (const InputError&) {
    return {};
  }
  return is_sound(value, size) ? std::optional(std::move(value)) : std::nullopt;
}

/// A reference of the room: its key, and the digest of what it is made from.
struct RoomMember {
  std::string key, recipe;
};

/// Where stages of one geometry, illumination and view are kept. One that is there whole, of the same members
/// or more and of this instruction set, is taken instead of being made; what cannot be used is made again.
/// Without a folder nothing is kept.
class RoomStages {
 public:
  RoomStages() = default;
  /// `folder`: of this room alone. `size`: of the study's pictures
  RoomStages(std::filesystem::path folder, std::vector<RoomMember> members, PixelSize size);

  bool are_kept() const { return !folder_.empty(); }

  /// What `make()` gives, or gave for the same members and others. `skip()` is called instead where it is
  /// there. errors: StoreError, and those of `make`
  template <typename T, typename Make, typename Skip>
  T keep(const std::string& stage, const Make& make, const Skip& skip) const {
    if (auto found = find<T>(stage, members_)) {
      skip();
      return std::move(*found);
    }
    T made = make();
    save(stage, members_, made);
    return made;
  }

  /// The same of stages that each of `count` members has for itself: `make(which)` gives those that are not
  /// there, by the members' places. shape: by member
  template <typename T, typename Make, typename Skip>
  std::vector<T> keep_each(const std::string& stage, std::size_t count, const Make& make,
                           const Skip& skip) const {
    EQ_CHECK(!are_kept() || count == members_.size(), count, members_.size());
    std::vector<std::optional<T>> found(count);
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < count; ++i) {
      if (are_kept()) found[i] = find<T>(stage + "-" + members_[i].key, {members_[i]});
      if (!found[i]) which.push_back(i);
    }
    if (which.empty()) {
      skip();
    } else {
      std::vector<T> made = make(which);
      for (std::size_t k = 0; k < which.size(); ++k) {
        if (are_kept()) save(stage + "-" + members_[which[k]].key, {members_[which[k]]}, made[k]);
        found[which[k]] = std::move(made[k]);
      }
    }
    std::vector<T> all;
    for (std::optional<T>& one : found) all.push_back(std::move(*one));
    return all;
  }

  /// When its references are whole.
  void remove() const;

 private:
  template <typename T>
  std::optional<T> find(const std::string& stage, const std::vector<RoomMember>& members) const {
    const std::optional<std::string> bytes = load(stage, members);
    if (!bytes) return {};
    return parse_stage<T>(*bytes, size_, stage);
  }
  template <typename T>
  void save(const std::string& stage, const std::vector<RoomMember>& members, const T& value) const {
    if (!are_kept()) return;
    StageWriter writer;
    writer.write(value);
    save_bytes(stage, members, writer.take());
  }
  std::optional<std::string> load(const std::string& stage, const std::vector<RoomMember>& members) const;
  void save_bytes(const std::string& stage, const std::vector<RoomMember>& members,
                  const std::string& bytes) const;
  std::filesystem::path path_of(const std::string& stage) const;

  std::filesystem::path folder_;
  std::vector<RoomMember> members_;
  PixelSize size_;
};

/// Names of the rooms of which stages are kept, sorted.
std::vector<std::string> list_rooms(const std::filesystem::path& rooms);

/// Removes stages that no run has come back to. errors: StoreError
void remove_room_stages(const std::filesystem::path& rooms);

}  // namespace equilux
