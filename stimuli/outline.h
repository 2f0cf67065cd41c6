// Closed outlines in the plane. Private to this folder.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace equilux {

using Point2 = std::array<float, 2>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Twice the signed area of a, b, c; in double, in which products of floats are exact.
double turn_of(const Point2& a, const Point2& b, const Point2& c);

double signed_area(const std::vector<Point2>& outline);

/// By cutting ears off a counter-clockwise outline; corners at which it goes straight on make no triangle.
/// Nothing for an outline of which no ear can be cut: it crosses itself.
std::optional<Triangles> triangulate(const std::vector<Point2>& outline);

}  // namespace equilux
