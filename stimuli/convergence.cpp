// Convergence files, and their advice in words.
#include "stimuli/convergence.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "base/files.h"
#include "base/progress.h"
#include "base/version.h"

namespace equilux {

extern const char kConvergenceSchema[];

namespace {

double sum_stages(const std::map<std::string, double>& stages) {
  return std::accumulate(stages.begin(), stages.end(), 0.0,
                         [](double sum, const auto& stage) { return sum + stage.second; });
}

Json make_stages_json(const std::map<std::string, double>& stages) {
  Json json{Json::Object{}};
  for (const auto& [stage, seconds] : stages) json.set(stage, seconds);
  return json;
}

std::map<std::string, double> read_stages(const Json& json) {
  std::map<std::string, double> stages;
  for (const auto& [stage, seconds] : json.as_object()) stages[stage] = seconds.as_double();
  return stages;
}

// The members of ErrorFigures under their names.
constexpr std::pair<const char*, double ErrorFigures::*> kFigures[] = {
    {"relative_rms", &ErrorFigures::relative_rms},
    {"relative_rms_error", &ErrorFigures::relative_rms_error},
    {"relative_mse", &ErrorFigures::relative_mse},
    {"bias", &ErrorFigures::bias},
    {"bias_low", &ErrorFigures::bias_low},
    {"bias_high", &ErrorFigures::bias_high},
    {"flip", &ErrorFigures::flip},
    {"share_over_one_step", &ErrorFigures::share_over_one_step}};

Json make_point_json(const ConvergencePoint& point) {
  Json error;
  for (const auto& [name, member] : kFigures) error.set(name, point.error.*member);
  Json json;
  json.set("series", point.series).set("setting", point.setting);
  if (point.vpls > 0) json.set("vpls", point.vpls);
  if (point.error_ratio > 0) json.set("error_ratio", point.error_ratio);
  if (point.clamp_level) json.set("clamp_level", *point.clamp_level);
  if (point.paths_a_pixel > 0) json.set("paths_a_pixel", point.paths_a_pixel);
  if (point.sets > 0) json.set("sets", point.sets);
  json.set("wall_s", make_stages_json(point.wall_s)).set("cpu_s", make_stages_json(point.cpu_s));
  return json.set("error", std::move(error));
}

ConvergencePoint read_point(const Json& json) {
  ConvergencePoint point;
  const auto integer = [&](const char* key) { return json.find(key) ? json.at(key).as_int() : 0; };
  point.series = json.at("series").as_string();
  point.setting = json.at("setting").as_string();
  point.vpls = integer("vpls");
  if (const Json* ratio = json.find("error_ratio")) point.error_ratio = ratio->as_double();
  if (const Json* level = json.find("clamp_level")) point.clamp_level = static_cast<int>(level->as_int());
  point.paths_a_pixel = static_cast<int>(integer("paths_a_pixel"));
  point.sets = static_cast<int>(integer("sets"));
  point.wall_s = read_stages(json.at("wall_s"));
  point.cpu_s = read_stages(json.at("cpu_s"));
  for (const auto& [name, member] : kFigures) point.error.*member = json.at("error").at(name).as_double();
  return point;
}

ConvergenceAdvice read_advice(const Json& json, std::size_t points, const std::string& source,
                              std::size_t row) {
  ConvergenceAdvice advice{json.at("seconds").as_double(), {}};
  if (const Json* point = json.find("point")) {
    const auto index = static_cast<std::size_t>(point->as_int());
    if (index >= points)
      throw InputError(source, fmt::format("/advice/{}/point", row), fmt::format("one of {} points", points),
                       fmt::format("{}", index));
    advice.point = index;
  }
  return advice;
}

Json make_parts_json(const std::vector<ErrorPart>& parts) {
  Json json{Json::Array{}};
  for (const ErrorPart& part : parts) {
    Json row;
    row.set("name", part.name).set("measured_by", part.measured_by).set("relative_rms", part.relative_rms);
    json.push(row.set("bias", part.bias).set("bias_error", part.bias_error));
  }
  return json;
}

Json make_slopes_json(const std::vector<FittedSlope>& slopes) {
  Json json{Json::Array{}};
  for (const FittedSlope& slope : slopes)
    json.push(Json{}.set("series", slope.series).set("slope", slope.slope));
  return json;
}

Json make_advice_json(const std::vector<ConvergenceAdvice>& advice) {
  Json json{Json::Array{}};
  for (const ConvergenceAdvice& one : advice) {
    Json row;
    row.set("seconds", one.seconds);
    if (one.point) row.set("point", *one.point);
    json.push(std::move(row));
  }
  return json;
}

// For files that do not have it: of equal pixels, in which the channels go together.
double guess_square_error(const Convergence& made) {
  return 1.5 * made.reference_rms * made.reference_rms / std::sqrt(static_cast<double>(made.object_pixels));
}

}  // namespace

double ConvergencePoint::wall() const { return sum_stages(wall_s); }
double ConvergencePoint::cpu() const { return sum_stages(cpu_s); }

Convergence load_convergence(const std::filesystem::path& path) {
  const Json json = load_json(path, kConvergenceSchema);
  Convergence made;
  made.source = json.at("source").as_string();
  made.condition = json.at("condition").as_string();
  const auto integer = [&](const char* key) { return static_cast<int>(json.at(key).as_int()); };
  made.width = integer("width");
  made.height = integer("height");
  made.positions = integer("positions");
  made.seed = static_cast<std::uint64_t>(json.at("seed").as_int());
  made.seeds = integer("seeds");
  made.threads = integer("threads");
  made.isa = json.at("isa").as_string();
  made.host = json.at("host").as_string();
  made.object_pixels = static_cast<std::size_t>(json.at("object_pixels").as_int());
  const Json& reference = json.at("reference");
  made.reference = reference.at("made_by").as_string();
  made.reference_mean = reference.at("mean").as_double();
  made.reference_rms = reference.at("relative_rms").as_double();
  const Json* square_error = reference.find("square_error");
  made.reference_square_error = square_error ? square_error->as_double() : guess_square_error(made);
  for (const Json& row : json.at("points").as_array()) made.points.push_back(read_point(row));
  for (const Json& row : json.at("slopes").as_array())
    made.slopes.push_back({row.at("series").as_string(), row.at("slope").as_double()});
  for (const Json& row : json.at("parts").as_array())
    made.parts.push_back({row.at("name").as_string(), row.at("measured_by").as_string(),
                          row.at("relative_rms").as_double(), row.at("bias").as_double(),
                          row.at("bias_error").as_double()});
  const auto& advice = json.at("advice").as_array();
  for (std::size_t row = 0; row < advice.size(); ++row)
    made.advice.push_back(read_advice(advice[row], made.points.size(), path.string(), row));
  if (const Json* left_out = json.find("left_out")) {
    for (const Json& what : left_out->as_array()) made.left_out.push_back(what.as_string());
  }
  return made;
}

void save_convergence(const Convergence& made, const std::filesystem::path& path) {
  Json points{Json::Array{}};
  for (const ConvergencePoint& point : made.points) points.push(make_point_json(point));
  Json reference;
  reference.set("made_by", made.reference)
      .set("mean", made.reference_mean)
      .set("relative_rms", made.reference_rms)
      .set("square_error", made.reference_square_error);
  Json json;
  json.set("schema", "equilux-convergence").set("schema_version", 1).set("producer_version", kVersion);
  json.set("source", made.source).set("condition", made.condition);
  json.set("width", made.width).set("height", made.height).set("positions", made.positions);
  json.set("seed", made.seed).set("seeds", made.seeds).set("threads", made.threads);
  json.set("isa", made.isa).set("host", made.host).set("object_pixels", made.object_pixels);
  json.set("reference", std::move(reference)).set("points", std::move(points));
  json.set("slopes", make_slopes_json(made.slopes)).set("parts", make_parts_json(made.parts));
  json.set("advice", make_advice_json(made.advice));
  Json left_out{Json::Array{}};
  for (const std::string& what : made.left_out) left_out.push(what);
  if (!made.left_out.empty()) json.set("left_out", std::move(left_out));
  save_text(path, format_json(json));
}

std::vector<std::string> list_series(const Convergence& convergence) {
  std::vector<std::string> series;
  for (const ConvergencePoint& point : convergence.points) {
    if (std::find(series.begin(), series.end(), point.series) == series.end()) series.push_back(point.series);
  }
  return series;
}

std::optional<double> find_slope(const Convergence& convergence, const std::string& series) {
  for (const FittedSlope& slope : convergence.slopes) {
    if (slope.series == series) return slope.slope;
  }
  return std::nullopt;
}

double find_least_error(const Convergence& convergence) {
  return std::sqrt(2 * convergence.reference_square_error);
}

bool is_resolved(const Convergence& convergence, const ConvergencePoint& point) {
  return point.error.relative_rms > 0 && point.error.relative_rms >= find_least_error(convergence);
}

std::vector<const ConvergencePoint*> find_frontier(const Convergence& convergence) {
  std::vector<const ConvergencePoint*> sorted, frontier;
  for (const ConvergencePoint& point : convergence.points) sorted.push_back(&point);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto* a, const auto* b) { return a->wall() < b->wall(); });
  double least = std::numeric_limits<double>::infinity();
  for (const ConvergencePoint* point : sorted) {
    const double error = std::max(point->error.relative_rms, find_least_error(convergence));
    if (error >= least) continue;
    least = error;
    frontier.push_back(point);
  }
  return frontier;
}

std::string format_error(const Convergence& convergence, const ConvergencePoint& point) {
  if (point.error.relative_rms == 0 && find_least_error(convergence) == 0) return "0 %";
  const bool resolved = is_resolved(convergence, point);
  const double percent = 100 * (resolved ? point.error.relative_rms : find_least_error(convergence));
  return (resolved ? "" : "under ") +
         (percent < 99.5 ? fmt::format("{:.2g} %", percent) : fmt::format("{:.0f} %", percent));
}

std::string format_error_interval(const Convergence& convergence, const ConvergencePoint& point) {
  if (!is_resolved(convergence, point)) return format_error(convergence, point);
  return fmt::format("{:.2f} ± {:.2f} %", 100 * point.error.relative_rms,
                     100 * point.error.relative_rms_error);
}

namespace {

constexpr double kNoisyReference = 0.15;  // rms

std::string format_time(double seconds) {
  return seconds < 0.095 ? fmt::format("{:.2g} s", seconds) : format_seconds(seconds);
}

}  // namespace

std::string format_advice(const Convergence& convergence) {
  std::string text;
  for (const ConvergenceAdvice& advice : convergence.advice) {
    if (!text.empty()) text += ' ';
    if (!advice.point) {
      text += fmt::format("No setting that was measured takes under {}.", format_time(advice.seconds));
      continue;
    }
    const ConvergencePoint& point = convergence.points[*advice.point];
    text += fmt::format("Within {}, the nearest to the truth is {} at {}: {} rms, in {}.",
                        format_time(advice.seconds), point.series, point.setting,
                        format_error_interval(convergence, point), format_time(point.wall()));
  }
  if (convergence.reference_rms > kNoisyReference) {
    if (!text.empty()) text += ' ';
    text +=
        fmt::format("The reference is noisy, by {:.2g} % rms: more paths for it would tell methods apart.",
                    100 * convergence.reference_rms);
  }
  return text;
}

}  // namespace equilux
