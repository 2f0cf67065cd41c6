// Rows of `session` and `field` to counts and ranges.
#include "analysis/participation.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <set>

namespace equilux {
namespace {

constexpr std::size_t kDayLength = 10;  ///< of 2026-01-31 in an ISO 8601 time

// Of what the window keeps with a session (docs/sessions.md), what a reader can judge viewing by.
constexpr const char* kCountedFields[] = {
    "language",           "consent_version",        "age_band",   "acuity",
    "colour_vision",      "ambient_light",          "video_mode", "content_scale",
    "pixel_pitch_source", "viewing_distance_source"};
constexpr const char* kMeasuredFields[] = {"pixel_pitch_x_mm", "pixel_pitch_y_mm", "refresh_hz_measured"};

std::string find_field(const SessionRow& row, const char* name) {
  const auto found = row.fields.find(name);
  return found == row.fields.end() ? "" : found->second;
}

std::optional<double> parse_measure(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

void add_value(Participation& sum, const char* name, const std::optional<double>& value) {
  if (!value) return;
  ValueRange& range = sum.ranges.try_emplace(name, ValueRange{*value, *value, 0}).first->second;
  range.least = std::min(range.least, *value);
  range.greatest = std::max(range.greatest, *value);
  ++range.sessions;
}

std::string format_framebuffer(const ScreenRecord& screen) {
  if (!screen.framebuffer_width || !screen.framebuffer_height) return "";
  return fmt::format("{}x{}", *screen.framebuffer_width, *screen.framebuffer_height);
}

void add_session(Participation& sum, const SessionRow& row) {
  ++sum.sessions;
  const std::string day = row.started_utc.substr(0, kDayLength);
  if (!day.empty()) {
    sum.first_day = sum.first_day.empty() ? day : std::min(sum.first_day, day);
    sum.last_day = std::max(sum.last_day, day);
  }
  for (const char* name : kCountedFields) ++sum.counts[name][find_field(row, name)];
  ++sum.counts["monitor"][row.screen.monitor];
  ++sum.counts["framebuffer"][format_framebuffer(row.screen)];
  for (const char* name : kMeasuredFields) add_value(sum, name, parse_measure(find_field(row, name)));
  add_value(sum, "viewing_distance_m", row.screen.viewing_distance_m);
  add_value(sum, "degrees_wide", row.screen.degrees_wide);
  add_value(sum, "degrees_high", row.screen.degrees_high);
}

std::set<std::string> find_participants(const ExperimentEvidence& evidence) {
  std::set<std::string> codes;
  for (const SessionRow& row : evidence.finished) codes.insert(row.participant);
  codes.erase("");
  return codes;
}

}  // namespace

Participation find_participation(const ExperimentEvidence& evidence) {
  Participation sum;
  for (const SessionRow& row : evidence.finished) add_session(sum, row);
  if (sum.sessions > 0 && sum.sessions < kFewestTold) {
    for (const char* name : {"age_band", "acuity", "colour_vision"}) sum.counts.erase(name);
  }
  return sum;
}

std::size_t count_in_both(const Evidence& evidence) {
  const auto artifact = find_participants(evidence.artifact);
  const auto material = find_participants(evidence.material);
  return static_cast<std::size_t>(std::count_if(
      material.begin(), material.end(), [&](const std::string& code) { return artifact.contains(code); }));
}

std::size_t count_participants(const ExperimentEvidence& evidence) {
  return find_participants(evidence).size();
}

Json make_participation_json(const Participation& participation) {
  Json counts{Json::Object{}}, ranges{Json::Object{}};
  for (const auto& [name, values] : participation.counts) {
    Json of_value{Json::Object{}};
    for (const auto& [value, sessions] : values)
      of_value.set(value.empty() ? "not recorded" : value, sessions);
    counts.set(name, std::move(of_value));
  }
  for (const auto& [name, range] : participation.ranges) {
    Json json;
    json.set("least", range.least).set("greatest", range.greatest).set("sessions", range.sessions);
    ranges.set(name, std::move(json));
  }
  Json json;
  json.set("first_day", participation.first_day).set("last_day", participation.last_day);
  return json.set("sessions_by_value", std::move(counts)).set("ranges", std::move(ranges));
}

}  // namespace equilux
