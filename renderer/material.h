// BRDFs: Lambertian and Ward-Duer. Directions are in the local frame of the shading normal (n = z), away from
// the surface.
#pragma once

#include <numbers>
#include <optional>

#include "stimuli/scene.h"

namespace equilux {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;

/// Roulette survives at most this often, so that paths end even between white walls; it divides by what it
/// used, so it stays unbiased. Weights above 1 (Ward-Duer near grazing) are kept, never capped.
inline constexpr float kLargestSurvival = 0.98f;

/// f = rho_d / pi + rho_s E / (4 pi alpha^2 cv cl), E = exp(-tan^2 t / alpha^2), t the half vector's angle.
/// source: Duer, "An improved normalization for the Ward reflectance model", JGT 11(1), 2006.
struct Material {
  Vec3 rho_d;
  Vec3 rho_s;
  float alpha = 0;
  float glossy_share = 0;  ///< probability of sampling the glossy lobe; 0 for Lambertian
};

Material make_material(const MaterialSpec& spec);

/// tan^2 of the half vector's angle, without the cancellation of the form in dot products. Infinite where H
/// lies in the surface.
inline float half_vector_tan2(Vec3 v, Vec3 l) {
  const Vec3 h = v + l;
  return (h.x * h.x + h.y * h.y) / (h.z * h.z);
}

/// BRDF. units: 1/sr. Zero unless l.z > 0; the glossy part also needs v.z > 0. No floor on the cosines.
Vec3 eval_brdf(const Material& material, Vec3 v, Vec3 l);

/// The luminance-free glossy factor E / (4 pi alpha^2 cv cl), zero outside v.z > 0, l.z > 0.
float eval_glossy(float alpha, Vec3 v, Vec3 l);

/// Density of the glossy lobe's sampling about v over solid angle; zero where sample_glossy rejects.
float pdf_glossy(float alpha, Vec3 v, Vec3 l);

/// A direction of the glossy lobe; empty where it falls below the horizon (the path then ends with weight 0).
std::optional<Vec3> sample_glossy(float alpha, Vec3 v, float u1, float u2);

Vec3 sample_cosine(float u1, float u2);

struct BrdfSample {
  Vec3 l;
  Vec3 weight;    ///< f cl / pdf
  float pdf = 0;  ///< over solid angle, of the mixture
};

/// Density of sample_brdf. Directions that it rejects carry the missing mass.
float pdf_brdf(const Material& material, Vec3 v, Vec3 l);

/// One-sample mixture of cosine and glossy lobe; `u0` chooses the lobe. Empty where the path ends.
std::optional<BrdfSample> sample_brdf(const Material& material, Vec3 v, float u0, float u1, float u2);

}  // namespace equilux
