// OBJ as its text says it: assimp drops some spellings of a number without a word, and with them vertices.
// source: Wavefront, Advanced Visualizer Manual, Appendix B1, "Object Files".
#include "stimuli/obj_file.h"

#include <algorithm>
#include <boost/interprocess/streams/bufferstream.hpp>
#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include "base/error.h"
#include "stimuli/outline.h"

namespace equilux {
namespace {

constexpr std::size_t kMaxCorners = 4096;  // of a face; cutting it takes the square of it, and more
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Statements that make no surface.
constexpr std::string_view kPassedOver[] = {
    "vt",     "vp",    "g",      "s",        "o",        "mg",         "usemtl",    "mtllib", "usemap",
    "maplib", "bevel", "lod",    "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech",  "stech",
    "p",      "l",     "cstype", "deg",      "bmat",     "step",       "parm",      "trim",   "hole",
    "scrv",   "sp",    "end",    "con",      "curv",     "curv2"};

bool is_passed_over(std::string_view kind) {
  return std::find(std::begin(kPassedOver), std::end(kPassedOver), kind) != std::end(kPassedOver);
}

// The next word of a line, which is taken from it; empty at the end.
std::string_view take_word(std::string_view& line) {
  const std::size_t start = std::min(line.find_first_not_of(" \t"), line.size());
  const std::size_t end = std::min(line.find_first_of(" \t", start), line.size());
  const std::string_view word = line.substr(start, end - start);
  line.remove_prefix(end);
  return word;
}

// A whole word as a number; from_chars takes no plus.
template <typename Number>
std::optional<Number> read_number(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  Number number{};
  const char* end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, number);
  return read.ec == std::errc() && read.ptr == end ? std::optional(number) : std::nullopt;
}

std::string quote(std::string_view word) {
  return word.empty() ? "the end of the line" : fmt::format("\"{}\"", word.substr(0, 40));
}

// Reads a file by its lines, those joined that a backslash continues; errors name the first of them.
class ObjLines {
 public:
  ObjLines(const std::string& source, const std::string& text)
      : source_(source), stream_(text.data(), text.size()) {}

  /// False at the end.
  bool next() {
    first_ = last_ + 1;
    if (!read(line_)) return false;
    while (line_.ends_with('\\')) {
      line_.pop_back();
      std::string more;
      if (!read(more)) refuse("a line after the backslash", "the end of the file");
      if (!ends_word(line_, line_.size()) && !ends_word(more, 0))
        refuse("a blank where a backslash joins two lines", "a word on both sides");
      line_ += more;
    }
    return true;
  }
  std::string_view line() const { return line_; }
  std::uint32_t number() const { return first_; }
  [[noreturn]] void refuse(const std::string& expected, const std::string& got) const {
    refuse_at(first_, expected, got);
  }
  [[noreturn]] void refuse_at(std::uint32_t number, const std::string& expected,
                              const std::string& got) const {
    throw InputError(source_, fmt::format("line {}", number), expected, got);
  }

 private:
  bool read(std::string& line) {
    if (!std::getline(stream_, line)) return false;
    ++last_;
    if (last_ == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
    if (line.ends_with('\r')) line.pop_back();
    // Some programs end lines at some of these.
    for (const char c : line) {
      if (static_cast<unsigned char>(c) < ' ' && c != '\t') refuse_at(last_, "text", "a control character");
    }
    line.erase(std::min(line.find('#'), line.size()));
    return true;
  }
  // True if no word goes on across that place; a backslash there is no part of one, or will be refused.
  static bool ends_word(const std::string& line, std::size_t place) {
    const std::size_t at = place == 0 ? 0 : place - 1;
    return line.empty() || line[at] == ' ' || line[at] == '\t' || line[at] == '\\';
  }

  std::string source_, line_;
  boost::interprocess::ibufferstream stream_;
  std::uint32_t first_ = 0, last_ = 0;
};

struct Corner {
  std::uint32_t position = 0, normal = kNone;
};

struct Face {
  std::uint32_t line, corners;
};

struct Obj {
  std::vector<Vec3> positions, normals;
  std::vector<Corner> corners;  ///< of all faces
  std::vector<Face> faces;
};

float take_float(std::string_view& line, const ObjLines& lines) {
  const std::string_view word = take_word(line);
  const auto number = read_number<double>(word);
  if (!number || !(std::abs(*number) <= std::numeric_limits<float>::max()))
    lines.refuse("a finite number within float's range", quote(word));
  return static_cast<float>(*number);
}

Vec3 take_vec(std::string_view& line, const ObjLines& lines) {
  const float x = take_float(line, lines), y = take_float(line, lines);
  return {x, y, take_float(line, lines)};
}

void expect_end(std::string_view line, const std::string& expected, const ObjLines& lines) {
  if (const std::string_view word = take_word(line); !word.empty())
    lines.refuse(expected, quote(word) + " more");
}

// Three coordinates; then a weight, which polygons do not have, or a colour.
Vec3 read_position(std::string_view line, const ObjLines& lines) {
  const Vec3 position = take_vec(line, lines);
  if (std::string_view rest = line; take_word(rest).empty()) return position;
  const float weight = take_float(line, lines);
  if (std::string_view rest = line; !take_word(rest).empty()) {
    take_float(line, lines);
    take_float(line, lines);
  } else if (weight != 1) {
    lines.refuse("a weight of 1, as polygons have it", fmt::format("{}", weight));
  }
  expect_end(line, "3 coordinates, with a weight or a colour at most", lines);
  return position;
}

Vec3 read_normal(std::string_view line, const ObjLines& lines) {
  const Vec3 normal = take_vec(line, lines);
  expect_end(line, "3 coordinates", lines);
  return normalize(normal);
}

// From zero; indices below zero count from the last that there is.
std::uint32_t read_index(std::string_view word, std::size_t count, const ObjLines& lines) {
  const auto index = read_number<std::int64_t>(word);
  if (!index || *index == 0 || *index > kNone)
    lines.refuse("an index, from 1 or from -1 backwards", quote(word));
  if (*index > 0) return static_cast<std::uint32_t>(*index - 1);
  if (*index < -static_cast<std::int64_t>(count))
    lines.refuse(fmt::format("an index to one of the {} before it", count), quote(word));
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(count) + *index);
}

// "1", "1/2", "1//3", "1/2/3"; what a slash leaves empty is not there.
Corner read_corner(std::string_view word, const Obj& obj, const ObjLines& lines) {
  const std::size_t first = std::min(word.find('/'), word.size());
  const std::size_t second = std::min(word.find('/', std::min(first + 1, word.size())), word.size());
  const std::string_view texture =
      word.substr(std::min(first + 1, second), second - std::min(first + 1, second));
  const std::string_view normal = word.substr(std::min(second + 1, word.size()));
  if (!texture.empty() && !read_number<std::int64_t>(texture))
    lines.refuse("an index of a texture coordinate", quote(word));
  Corner corner{read_index(word.substr(0, first), obj.positions.size(), lines), kNone};
  if (!normal.empty()) corner.normal = read_index(normal, obj.normals.size(), lines);
  return corner;
}

void read_face(std::string_view line, Obj& obj, const ObjLines& lines) {
  Face face{lines.number(), 0};
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
    if (++face.corners > kMaxCorners)
      lines.refuse(fmt::format("at most {} corners in a face", kMaxCorners), "more");
    obj.corners.push_back(read_corner(word, obj, lines));
  }
  if (face.corners < 3) lines.refuse("at least 3 corners in a face", fmt::format("{}", face.corners));
  obj.faces.push_back(face);
}

void read_line(Obj& obj, const ObjLines& lines) {
  std::string_view rest = lines.line();
  const std::string_view kind = take_word(rest);
  if (kind == "v") {
    obj.positions.push_back(read_position(rest, lines));
  } else if (kind == "vn") {
    obj.normals.push_back(read_normal(rest, lines));
  } else if (kind == "f" || kind == "fo") {
    read_face(rest, obj, lines);
  } else if (!kind.empty() && !is_passed_over(kind)) {
    lines.refuse("v, vn, f or a statement of OBJ that makes no surface", quote(kind));
  }
}

// Indices may go forward, so they are checked when all is read.
void check_face(const Obj& obj, const Face& face, const Corner* corners, const ObjLines& lines) {
  const auto check = [&](std::uint32_t index, std::size_t count, const char* what) {
    if (index >= count) {
      lines.refuse_at(face.line, fmt::format("{} of the {} in the file", what, count),
                      fmt::format("{}", std::uint64_t{index} + 1));
    }
  };
  for (std::uint32_t i = 0; i < face.corners; ++i) {
    check(corners[i].position, obj.positions.size(), "vertices");
    if (corners[i].normal != kNone) check(corners[i].normal, obj.normals.size(), "normals");
  }
}

// True for a polygon without an area, to within float's rounding.
bool is_straight(const std::vector<Vec3>& polygon) {
  const auto from_first = [&](Vec3 p) { return length(p - polygon[0]); };
  const Vec3 farthest = *std::max_element(polygon.begin(), polygon.end(),
                                          [&](Vec3 a, Vec3 b) { return from_first(a) < from_first(b); });
  return std::none_of(polygon.begin(), polygon.end(),
                      [&](Vec3 p) { return spans_area(farthest - polygon[0], p - polygon[0]); });
}

// Along the axis on which it looks largest, counter-clockwise.
std::vector<Point2> project(const std::vector<Vec3>& polygon) {
  const auto outline_of = [&](float Vec3::*u, float Vec3::*v) {
    std::vector<Point2> outline;
    for (const Vec3& p : polygon) outline.push_back({p.*u, p.*v});
    return outline;
  };
  std::vector<Point2> largest;
  for (const auto& [u, v] : {std::pair{&Vec3::x, &Vec3::y}, {&Vec3::y, &Vec3::z}, {&Vec3::z, &Vec3::x}}) {
    std::vector<Point2> outline = outline_of(u, v);
    if (largest.empty() || std::abs(signed_area(outline)) > std::abs(signed_area(largest))) largest = outline;
  }
  if (signed_area(largest) < 0) {
    for (Point2& p : largest) std::swap(p[0], p[1]);
  }
  return largest;
}

// A convex polygon as the fan about its first corner: the search for ears starts at the second.
std::optional<Triangles> cut_polygon(const std::vector<Vec3>& polygon) {
  if (is_straight(polygon)) return Triangles();
  std::vector<Vec3> turned = polygon;
  std::rotate(turned.begin(), turned.begin() + 1, turned.end());
  auto triangles = triangulate(project(turned));
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (std::size_t i = 0; triangles && i < triangles->size(); ++i) {
    for (std::uint32_t& corner : (*triangles)[i]) corner = (corner + 1) % n;
  }
  return triangles;
}

void add_face(TriangleMesh& mesh, const Obj& obj, const Face& face, const Corner* corners,
              const ObjLines& lines, MeshRepairs& found) {
  check_face(obj, face, corners, lines);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t i = 0; i < face.corners; ++i) {
    mesh.positions.push_back(obj.positions[corners[i].position]);
    mesh.normals.push_back(corners[i].normal == kNone ? Vec3{} : obj.normals[corners[i].normal]);
  }
  if (face.corners == 3) {
    mesh.triangles.push_back({first, first + 1, first + 2});
    return;
  }
  const auto triangles = cut_polygon({mesh.positions.begin() + first, mesh.positions.end()});
  if (!triangles)
    lines.refuse_at(face.line, "a polygon that does not cross itself", "one that cannot be cut");
  for (const auto& [a, b, c] : *triangles) mesh.triangles.push_back({first + a, first + b, first + c});
  found.degenerate_triangles += face.corners - 2 - triangles->size();
}

std::size_t count_duplicates(std::vector<Vec3> points) {
  const auto as_array = [](Vec3 p) { return std::array{p.x, p.y, p.z}; };
  std::sort(points.begin(), points.end(), [&](Vec3 a, Vec3 b) { return as_array(a) < as_array(b); });
  const auto end = std::unique(points.begin(), points.end());
  return static_cast<std::size_t>(points.end() - end);
}

}  // namespace

bool has_extension(const std::filesystem::path& path, std::string_view extension) {
  std::string own = path.extension().string();
  for (char& c : own) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return own == extension;
}

bool is_obj(const std::filesystem::path& path, std::string_view text) {
  if (has_extension(path, ".obj")) return true;
  if (has_extension(path, ".ply") || has_extension(path, ".stl")) return false;
  constexpr std::size_t kStart = 4096;
  std::istringstream lines(std::string(text.substr(0, kStart)));
  for (std::string line; std::getline(lines, line);) {
    std::string_view rest = line;
    const std::string_view kind = take_word(rest);
    if (kind.empty() || kind[0] == '#' || kind == "\r") continue;
    return kind == "v" || kind == "vn" || kind == "f" || is_passed_over(kind);
  }
  return false;
}

TriangleMesh read_obj(const std::string& source, const std::string& text, MeshRepairs& found) {
  ObjLines lines(source, text);
  Obj obj;
  while (lines.next()) read_line(obj, lines);
  TriangleMesh mesh;
  const Corner* corners = obj.corners.data();
  for (const Face& face : obj.faces) {
    add_face(mesh, obj, face, corners, lines, found);
    corners += face.corners;
  }
  found.duplicate_vertices += count_duplicates(std::move(obj.positions));
  return mesh;
}

}  // namespace equilux
