// Conditions of a study and their keys: G1-MR-ind-100k-C4-v0.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

namespace equilux {

enum class Illumination { kIndirect, kDirectAndIndirect };

inline constexpr int kClampLevelCount = 11;  ///< C0 (no clamp) .. C10
inline constexpr int kViewCount = 2;

/// c of a clamp level. units: 1/m^2; C0 is infinity, Ci is 10^(2.5 - (i-1)/2).
double clamp_per_m2(int clamp_level);

/// A geometry and a material under an illumination: what a subject calls "the object". Key: G1-MR-ind.
struct Object {
  std::string geometry;
  std::string material;
  Illumination illumination = Illumination::kIndirect;
  auto operator<=>(const Object&) const = default;
};

/// An object at a VPL count: eleven cells, from which one cut each way is read. Key: G1-MR-ind-100k.
struct Column {
  Object object;
  std::int64_t vpl_count = 0;
  auto operator<=>(const Column&) const = default;
};

/// A column at a clamp level, the views pooled: what k of n subjects got right. Key: G1-MR-ind-100k-C4, or
/// C4n normalised.
struct Cell {
  Column column;
  int clamp_level = 0;
  bool normalised = false;
  auto operator<=>(const Cell&) const = default;
};

/// A cell in a view: one VPL picture. Key: G1-MR-ind-100k-C4-v0.
struct Condition {
  Cell cell;
  int view = 0;
  auto operator<=>(const Condition&) const = default;
};

/// An object in a view: one background, one direct layer, one reference picture, one tone curve. Key of its
/// reference: G1-MR-ind-ref-v0.
struct Family {
  Object object;
  int view = 0;
  auto operator<=>(const Family&) const = default;
};

std::string format_illumination(Illumination illumination);
std::string format_vpl_count(std::int64_t vpl_count);
std::string format_clamp(int clamp_level, bool normalised = false);
std::string format_key(const Object& object);
std::string format_key(const Column& column);
std::string format_key(const Cell& cell);
std::string format_key(const Condition& condition);
std::string format_key(const Family& family);

/// Exact inverses of the formats. `source` and `place` say where the text stands.
/// errors: InputError naming them, the form expected and the text.
Illumination parse_illumination(std::string_view text, std::string_view source, std::string_view place = "");
std::int64_t parse_vpl_count(std::string_view text, std::string_view source, std::string_view place = "");
int parse_clamp_level(std::string_view text, std::string_view source, std::string_view place = "");
Column parse_column(std::string_view text, std::string_view source, std::string_view place = "");
Cell parse_cell(std::string_view text, std::string_view source, std::string_view place = "");
Condition parse_condition(std::string_view text, std::string_view source, std::string_view place = "");
Family parse_family(std::string_view text, std::string_view source, std::string_view place = "");

/// True for letters and digits that begin with a letter, at most 32: what may stand between the dashes of a
/// key.
bool is_token(std::string_view text);

/// True for what parse_vpl_count takes.
bool is_vpl_count(std::string_view text);

Family family_of(const Condition& condition);

}  // namespace equilux
