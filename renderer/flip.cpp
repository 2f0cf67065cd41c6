// The two pipelines of FLIP, colour and feature, and how they are joined.
#include "renderer/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "base/error.h"
#include "renderer/tone.h"

namespace equilux {
namespace {

using Triple = std::array<double, 3>;
using Plane = std::vector<double>;  // shape: height x width

// Exponents, contrast and stretch of the paper's section 4.
constexpr double kColourExponent = 0.7, kFeatureExponent = 0.5;
constexpr double kKnee = 0.4, kKneeError = 0.95;
// Width of the feature detectors. units: degrees
constexpr double kFeatureWidth = 0.082;

// The sRGB primaries and their white, D65.
constexpr double kRgbToXyz[3][3] = {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};
constexpr double kXyzToRgb[3][3] = {{3.241003232976359, -1.537398969488785, -0.498615881996363},
                                    {-0.969224252202516, 1.875929983695176, 0.041554226340085},
                                    {0.055639419851975, -0.204011206123910, 1.057148977187533}};

Triple multiply(const double (&matrix)[3][3], const Triple& v) {
  Triple product{};
  for (std::size_t row = 0; row < 3; ++row)
    product[row] = matrix[row][0] * v[0] + matrix[row][1] * v[1] + matrix[row][2] * v[2];
  return product;
}

const Triple& white() {
  static const Triple kWhite = multiply(kRgbToXyz, {1, 1, 1});
  return kWhite;
}

Triple to_relative_xyz(const Triple& rgb) {
  Triple xyz = multiply(kRgbToXyz, rgb);
  for (std::size_t c = 0; c < 3; ++c) xyz[c] /= white()[c];
  return xyz;
}

// A linearised CIELab, in which filters are linear.
Triple to_opponent(const Triple& rgb) {
  const Triple xyz = to_relative_xyz(rgb);
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}

Triple from_opponent(const Triple& opponent) {
  const double y = (opponent[0] + 16) / 116;
  const Triple xyz{(y + opponent[1] / 500) * white()[0], y * white()[1],
                   (y - opponent[2] / 200) * white()[2]};
  Triple rgb = multiply(kXyzToRgb, xyz);
  for (double& value : rgb) value = std::clamp(value, 0.0, 1.0);
  return rgb;
}

double compress(double t) {
  constexpr double kDelta = 6.0 / 29;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
}

// CIELab, its chroma scaled by lightness after Hunt.
Triple to_hunt_lab(const Triple& rgb) {
  const Triple xyz = to_relative_xyz(rgb);
  const double x = compress(xyz[0]), y = compress(xyz[1]), z = compress(xyz[2]);
  const double lightness = 116 * y - 16;
  return {lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)};
}

// Abasi et al.'s distance for large differences.
double measure_hyab(const Triple& a, const Triple& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// Differences up to 1: most of the range for those under the knee.
double remap(double difference, double largest) {
  const double knee = kKnee * largest;
  if (difference < knee) return difference * kKneeError / knee;
  return kKneeError + (difference - knee) / (largest - knee) * (1 - kKneeError);
}

// Weights of offsets along one axis.
struct Kernel {
  int radius = 0;
  std::vector<double> weights;

  Kernel(int kernel_radius, const std::function<double(double)>& weigh) : radius(kernel_radius) {
    for (int i = -radius; i <= radius; ++i) weights.push_back(weigh(i));
  }

  // Positive and negative weights each sum to 1 in size. A detector whose sides lie within one pixel sees
  // nothing.
  void normalise() {
    double positive = 0, negative = 0;
    for (double weight : weights) (weight > 0 ? positive : negative) += std::abs(weight);
    if (positive == 0) weights.assign(weights.size(), 0);
    for (double& weight : weights) weight /= weight > 0 ? positive : std::max(negative, 1e-300);
  }
};

struct Size {
  int width, height;
};

Plane filter_row_wise(const Plane& plane, Size size, const Kernel& kernel) {
  Plane filtered(plane.size());
  for (int y = 0; y < size.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width);
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      for (int i = -kernel.radius; i <= kernel.radius; ++i) {
        const auto from = static_cast<std::size_t>(std::clamp(x + i, 0, size.width - 1));
        sum += kernel.weights[static_cast<std::size_t>(i + kernel.radius)] * plane[row + from];
      }
      filtered[row + static_cast<std::size_t>(x)] = sum;
    }
  }
  return filtered;
}

Plane filter_column_wise(const Plane& plane, Size size, const Kernel& kernel) {
  Plane filtered(plane.size());
  const auto width = static_cast<std::size_t>(size.width);
  for (int y = 0; y < size.height; ++y) {
    for (int i = -kernel.radius; i <= kernel.radius; ++i) {
      const auto from = static_cast<std::size_t>(std::clamp(y + i, 0, size.height - 1)) * width;
      const double weight = kernel.weights[static_cast<std::size_t>(i + kernel.radius)];
      for (std::size_t x = 0; x < width; ++x)
        filtered[static_cast<std::size_t>(y) * width + x] += weight * plane[from + x];
    }
  }
  return filtered;
}

Plane filter(const Plane& plane, Size size, const Kernel& across, const Kernel& down) {
  return filter_column_wise(filter_row_wise(plane, size, across), size, down);
}

// One Gaussian of a contrast sensitivity function, a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees.
struct Gaussian {
  double a, b;
};
// Of luminance, red-green, blue-yellow. source: table 1
const std::vector<Gaussian> kSensitivity[3] = {{{1, 0.0047}}, {{1, 0.0053}}, {{34.1, 0.04}, {13.5, 0.025}}};
constexpr double kWidestGaussian = 0.04;

// Each Gaussian separates; their sum has the weight 1.
Plane blur(const Plane& plane, Size size, const std::vector<Gaussian>& gaussians, double ppd) {
  constexpr double kPi2 = std::numbers::pi * std::numbers::pi;
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(kWidestGaussian / (2 * kPi2)) * ppd));
  Plane sum(plane.size());
  double weight = 0;
  for (const Gaussian& gaussian : gaussians) {
    const Kernel kernel(radius, [&](double x) { return std::exp(-kPi2 * x * x / (ppd * ppd * gaussian.b)); });
    double line = 0;
    for (double value : kernel.weights) line += value;
    const double scale = gaussian.a * std::sqrt(std::numbers::pi / gaussian.b);
    const Plane part = filter(plane, size, kernel, kernel);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += scale * part[i];
    weight += scale * line * line;
  }
  for (double& value : sum) value /= weight;
  return sum;
}

// What the eye makes of a picture: blurred colours and the luminance in which features are looked for.
struct Seen {
  std::vector<Triple> lab;
  Plane grey;
};

Seen see(const LdrImage& picture, double ppd) {
  const Size size{picture.width, picture.height};
  const std::size_t pixels = picture.values.size() / 3;
  std::array<Plane, 3> opponent{Plane(pixels), Plane(pixels), Plane(pixels)};
  for (std::size_t i = 0; i < pixels; ++i) {
    Triple rgb{};
    for (std::size_t c = 0; c < 3; ++c) rgb[c] = decode_srgb(picture.values[3 * i + c] / 255.0);
    const Triple value = to_opponent(rgb);
    for (std::size_t c = 0; c < 3; ++c) opponent[c][i] = value[c];
  }
  Seen seen{std::vector<Triple>(pixels), Plane(pixels)};
  for (std::size_t i = 0; i < pixels; ++i) seen.grey[i] = (opponent[0][i] + 16) / 116;
  for (std::size_t c = 0; c < 3; ++c) opponent[c] = blur(opponent[c], size, kSensitivity[c], ppd);
  for (std::size_t i = 0; i < pixels; ++i)
    seen.lab[i] = to_hunt_lab(from_opponent({opponent[0][i], opponent[1][i], opponent[2][i]}));
  return seen;
}

// Sizes of a picture's gradient by a detector of edges (order 1) or points (order 2).
Plane detect(const Plane& grey, Size size, double ppd, int order) {
  const double deviation = 0.5 * kFeatureWidth * ppd;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  const auto gaussian = [&](double x) { return std::exp(-x * x / (2 * deviation * deviation)); };
  Kernel across(radius, [&](double x) {
    return gaussian(x) * (order == 1 ? -x : x * x / (deviation * deviation) - 1);
  });
  Kernel along(radius, gaussian);
  across.normalise();
  along.normalise();
  const Plane horizontal = filter(grey, size, across, along), vertical = filter(grey, size, along, across);
  Plane sizes(grey.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = std::hypot(horizontal[i], vertical[i]);
  return sizes;
}

Plane compare_features(const Seen& a, const Seen& b, Size size, double ppd) {
  Plane differences(a.grey.size());
  for (int order : {1, 2}) {
    const Plane of_a = detect(a.grey, size, ppd, order), of_b = detect(b.grey, size, ppd, order);
    for (std::size_t i = 0; i < differences.size(); ++i)
      differences[i] = std::max(differences[i], std::abs(of_a[i] - of_b[i]));
  }
  for (double& difference : differences)
    difference = std::min(1.0, std::pow(difference * std::numbers::sqrt2 / 2, kFeatureExponent));
  return differences;
}

}  // namespace

std::vector<double> measure_flip(const LdrImage& reference, const LdrImage& test, double pixels_per_degree) {
  EQ_CHECK(reference.width == test.width && reference.height == test.height, reference.values.size(),
           test.values.size());
  EQ_CHECK(pixels_per_degree > 0, pixels_per_degree);
  const Size size{reference.width, reference.height};
  const Seen a = see(reference, pixels_per_degree), b = see(test, pixels_per_degree);
  const double largest =
      std::pow(measure_hyab(to_hunt_lab({0, 1, 0}), to_hunt_lab({0, 0, 1})), kColourExponent);
  std::vector<double> errors = compare_features(a, b, size, pixels_per_degree);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double colour = remap(std::pow(measure_hyab(a.lab[i], b.lab[i]), kColourExponent), largest);
    errors[i] = std::pow(colour, 1 - errors[i]);
  }
  return errors;
}

}  // namespace equilux
