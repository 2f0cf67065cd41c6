// A file a stage: a digest, then what it is of, then its bytes.
#include "renderer/room_stages.h"

#include <algorithm>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "renderer/isa.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

constexpr const char* kSchema = "equilux-room-stage";
constexpr int kVersionOfStages = 1;  // raised whenever a stage has other members
constexpr std::string_view kEnding = ".stage";
constexpr std::size_t kDigits = 64;
// Of the plan, which has most: maps, images and errors, with what stands before them.
constexpr std::size_t kMostBytesOfPixel = 160, kMostHeadBytes = std::size_t{1} << 20;

// What a stage was made from and by; the program's version is told, and not compared.
struct Head {
  std::string schema = kSchema;
  int version = kVersionOfStages;
  std::string producer, isa, stage;
  std::vector<std::string> recipes;
};

template <Is<Head> T>
auto members(T& head) {
  return std::tie(head.schema, head.version, head.producer, head.isa, head.stage, head.recipes);
}

bool is_of(const Head& head, const std::string& stage, const std::vector<RoomMember>& wanted) {
  const auto has = [&](const RoomMember& member) {
    return std::find(head.recipes.begin(), head.recipes.end(), member.recipe) != head.recipes.end();
  };
  return head.schema == kSchema && head.version == kVersionOfStages &&
         head.isa == format_isa(current_isa()) && head.stage == stage &&
         std::all_of(wanted.begin(), wanted.end(), has);
}

void remove_file(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error) throw StoreError(fmt::format("{}: cannot remove: {}", path.string(), error.message()));
}

bool has_stages(const fs::path& folder) {
  std::error_code gone;
  const auto entries = fs::directory_iterator(folder, gone);
  return std::any_of(begin(entries), end(entries),
                     [](const auto& entry) { return entry.path().extension() == kEnding; });
}

// Nothing but stages: the folder goes with them if it has nothing else.
void remove_stages(const fs::path& folder) {
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator(folder, gone)) {
    if (entry.path().extension() == kEnding) remove_file(entry.path());
  }
  std::error_code has_more;
  fs::remove(folder, has_more);
}

}  // namespace

RoomStages::RoomStages(fs::path folder, std::vector<RoomMember> members, PixelSize size)
    : folder_(std::move(folder)), members_(std::move(members)), size_(size) {
  std::error_code none;
  if (fs::is_symlink(folder_, none))
    throw InputError(folder_.string(), "", "a folder in the study folder",
                     "a symbolic link, through which stages would be written and removed elsewhere");
  if (path_exists(folder_)) remove_stale_parts(folder_);
}

fs::path RoomStages::path_of(const std::string& stage) const {
  return folder_ / (stage + std::string(kEnding));
}

std::optional<std::string> RoomStages::load(const std::string& stage,
                                            const std::vector<RoomMember>& members) const {
  if (!are_kept() || !is_file(path_of(stage))) return {};
  const auto pixels = static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(size_.height);
  try {  // of a file that may be anybody's: the boundary to making it again
    const std::string text = load_text(path_of(stage), kMostHeadBytes + kMostBytesOfPixel * pixels);
    const std::string_view rest = std::string_view(text).substr(std::min(kDigits, text.size()));
    if (digest_text(rest) != text.substr(0, kDigits)) return {};
    StageReader reader(rest, size_, path_of(stage).string());
    Head head;
    reader.read(head);
    if (!is_of(head, stage, members)) return {};
    return std::string(reader.left());
  } catch (const InputError&) {
    return {};
  }
}

void RoomStages::save_bytes(const std::string& stage, const std::vector<RoomMember>& members,
                            const std::string& bytes) const {
  Head head{.producer = kVersion, .isa = format_isa(current_isa()), .stage = stage, .recipes = {}};
  for (const RoomMember& member : members) head.recipes.push_back(member.recipe);
  StageWriter writer;
  writer.write(head);
  const std::string text = writer.take() + bytes;
  make_folder(folder_);
  save_text(path_of(stage), digest_text(text) + text);
}

void RoomStages::remove() const {
  if (!are_kept()) return;
  remove_stages(folder_);
  std::error_code has_more;
  fs::remove(folder_.parent_path(), has_more);
}

std::vector<std::string> list_rooms(const fs::path& rooms) {
  std::vector<std::string> names;
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator(rooms, gone)) {
    if (has_stages(entry.path())) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void remove_room_stages(const fs::path& rooms) {
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator(rooms, gone)) {
    if (entry.is_directory() && !entry.is_symlink()) remove_stages(entry.path());
  }
  std::error_code has_more;
  fs::remove(rooms, has_more);
}

}  // namespace equilux
