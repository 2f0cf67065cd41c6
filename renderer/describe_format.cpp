// A scene's numbers as aligned tables.
#include <cmath>
#include <fmt/format.h>

#include "renderer/describe.h"

namespace equilux {
namespace {

constexpr Illumination kIlluminations[] = {Illumination::kIndirect, Illumination::kDirectAndIndirect};

std::string format_percent(const Share& share) {
  if (share.total == 0) return "-";
  return fmt::format("{:.1f} %", 100 * double(share.count) / double(share.total));
}

// Three digits that count, without an exponent where a person would write none.
std::string format_number(double value) {
  if (value == 0) return "0";
  if (!std::isfinite(value)) return "inf";
  if (std::abs(value) >= 1e5 || std::abs(value) < 1e-4) return fmt::format("{:.2e}", value);
  const int whole_digits = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
  return fmt::format("{:.{}f}", value, std::max(0, 3 - whole_digits));
}

std::string format_counts(const Description& description) {
  const SceneCounts& counts = description.counts;
  std::string text =
      fmt::format("scene {}: {} instances of {} triangles, {} materials\n\n{:<14}{:>8}{:>12}{:>13}\n",
                  description.name, counts.instances, counts.room_triangles, counts.materials, "lights",
                  "spots", "rectangles", "environment");
  for (std::size_t i = 0; i < std::size(kIlluminations); ++i)
    text += fmt::format("{:<14}{:>8}{:>12}{:>13}\n", format_illumination(kIlluminations[i]),
                        counts.lights[i].spots, counts.lights[i].rectangles, counts.lights[i].environments);
  return text;
}

std::string format_row(const GeometryDescription& geometry) {
  if (!geometry.missing.empty()) return fmt::format("{:<10}{}\n", geometry.name, geometry.missing);
  const Bumpiness& shape = geometry.bumpiness;
  std::string text = fmt::format("{:<10}{:>10}{:>9}{:>9}{:>9}{:>9}{:>9.2f}", geometry.name,
                                 geometry.triangles, format_percent(geometry.coverage[0]),
                                 format_percent(geometry.coverage[1]), format_number(shape.mean_radius_m),
                                 format_number(shape.max_radius_m), shape.rms_angle_degrees);
  for (double band : shape.rms_log_radius) text += fmt::format("{:>8.4f}", band);
  return text + fmt::format("{:>10}{:>10}\n", format_percent(geometry.self_occlusion),
                            format_percent(geometry.self_mirroring));
}

std::string format_geometries(const std::vector<GeometryDescription>& geometries) {
  std::string text = fmt::format(
      "Seen: share of {} x {} pixels. Radius from the centre of volume. Angle between normal and radius, rms "
      "over the\narea; ln radius, rms over directions, by degree of spherical harmonics. Meets itself: share "
      "of rays spread by\ncosine, and of mirror rays in v0.\n\n",
      kDescribeWidth, kDescribeHeight);
  text += fmt::format("{:<10}{:>10}{:>18}{:>18}{:>9}{:>40}{:>20}\n", "", "", "seen in", "radius, m", "angle,",
                      "ln radius by degree", "meets itself by");
  text += fmt::format("{:<10}{:>10}{:>9}{:>9}{:>9}{:>9}{:>9}{:>8}{:>8}{:>8}{:>8}{:>8}{:>10}{:>10}\n",
                      "geometry", "triangles", "v0", "v1", "mean", "max", "degrees", "1", "2-3", "4-7",
                      "8-15", "16-31", "cosine", "mirror");
  for (const GeometryDescription& geometry : geometries) text += format_row(geometry);
  return text;
}

// What is not zero, by name; empty if all is.
std::string format_repairs(const GeometryDescription& geometry) {
  const MeshRepairs& repairs = geometry.repairs;
  std::string text;
  const auto add = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, count == 1 ? one : many);
  };
  add(repairs.duplicate_vertices, "duplicate vertex joined", "duplicate vertices joined");
  add(repairs.degenerate_triangles, "degenerate triangle left out", "degenerate triangles left out");
  add(repairs.duplicate_triangles, "duplicate triangle left out", "duplicate triangles left out");
  add(repairs.non_manifold_edges, "non-manifold edge", "non-manifold edges");
  add(repairs.non_manifold_vertices, "non-manifold vertex split", "non-manifold vertices split");
  add(repairs.open_edges, "open edge", "open edges");
  return text.empty() ? "" : fmt::format("{} has {}\n", geometry.name, text);
}

std::string format_direct(const DirectLight& direct, const std::vector<std::string>& names) {
  if (direct.lit.empty()) return "no light is on";
  const std::string size = fmt::format("{} points x {} lights", direct.points, direct.lit.size());
  if (direct.lit_count() == 0) return fmt::format("no light reaches the object ({})", size);
  const std::size_t brightest = direct.brightest();
  return fmt::format("{} of {} pairs are lit ({}), {} points by {}", direct.lit_count(), direct.pair_count(),
                     size, direct.lit[brightest], names[brightest]);
}

std::string format_direct_light(const Description& description) {
  std::string text = "Direct light, by shadow rays from points that are even by area.\n\n";
  for (const GeometryDescription& geometry : description.geometries) {
    for (std::size_t i = 0; i < std::size(kIlluminations) && geometry.missing.empty(); ++i)
      text += fmt::format("{:<10}{}: {}\n", geometry.name, format_illumination(kIlluminations[i]),
                          format_direct(geometry.direct[i], description.lights[i]));
  }
  return text;
}

std::string format_clamp_row(const Description& description, int level) {
  const auto index = static_cast<std::size_t>(level);
  const double clamp = clamp_per_m2(level);
  std::string text =
      fmt::format("{:<7}{:>10}", format_clamp(level), level == 0 ? "none" : format_number(clamp));
  for (const ClampReach& reach : description.reaches)
    text += fmt::format("{:>{}}", format_number(reach.distance_m[index]),
                        std::max<std::size_t>(9, reach.material.size() + 2));
  if (!description.bite.material.empty())
    text += fmt::format("{:>14}", format_percent(description.bite.bitten[index]));
  return text + "\n";
}

std::string format_clamp_head(const Description& description) {
  std::string text = fmt::format("{:<7}{:>10}", "level", "c, 1/m^2");
  for (const ClampReach& reach : description.reaches)
    text += fmt::format("{:>{}}", reach.material, std::max<std::size_t>(9, reach.material.size() + 2));
  const ClampBite& bite = description.bite;
  if (!bite.material.empty()) text += fmt::format("{:>14}", bite.geometry + "-" + bite.material);
  return text + "\n";
}

std::string format_bite(const ClampBite& bite) {
  if (bite.material.empty()) return "";
  std::string text = fmt::format(
      "\nLast column: positions of {} in v0 whose mirror ray ends within r_c at its angle: the level bites "
      "on "
      "what {}\nreflects there. ",
      bite.geometry, bite.material);
  if (bite.rays == 0) return text + "None leaves the object.\n";
  text += "Lengths of the mirror rays, m:";
  for (std::size_t i = 0; i < kLengthShares.size(); ++i)
    text += fmt::format("{} {:.0f} % {}", i > 0 ? "," : "", 100 * kLengthShares[i],
                        format_number(bite.length_quantiles_m[i]));
  return text + "\n";
}

std::string format_clamps(const Description& description) {
  if (description.reaches.empty()) return "No glossy material: name others by --material.\n";
  std::string text =
      "Clamp levels: r_c, the distance in m within which a level cuts what a material reflects at its peak, "
      "at "
      "normal\nincidence; that of a glossy one grows towards silhouettes as one over the root of the "
      "cosine.\n\n";
  text += format_clamp_head(description);
  for (int level = 0; level < kClampLevelCount; ++level) text += format_clamp_row(description, level);
  return text + format_bite(description.bite);
}

}  // namespace

std::string format_description(const Description& description) {
  std::string repairs;
  for (const GeometryDescription& geometry : description.geometries) repairs += format_repairs(geometry);
  return format_counts(description) + "\n" + format_geometries(description.geometries) +
         (repairs.empty() ? "" : "\n" + repairs) + "\n" + format_direct_light(description) + "\n" +
         format_clamps(description);
}

}  // namespace equilux
