// Outlines cut into triangles, of extrusions and of the polygons of a file.
#include "stimuli/outline.h"

#include <cstddef>

namespace equilux {
namespace {

bool is_inside(const Point2& p, const Point2& a, const Point2& b, const Point2& c) {
  return turn_of(a, b, p) >= 0 && turn_of(b, c, p) >= 0 && turn_of(c, a, p) >= 0;
}

// True if the corner at `i` of what is left can be cut off: it is convex, and no other point lies in it.
bool is_ear(const std::vector<Point2>& outline, const std::vector<std::uint32_t>& left, std::size_t i) {
  const std::size_t n = left.size(), before = (i + n - 1) % n, after = (i + 1) % n;
  const Point2 &a = outline[left[before]], &b = outline[left[i]], &c = outline[left[after]];
  if (!(turn_of(a, b, c) > 0)) return false;
  for (std::size_t j = 0; j < n; ++j) {
    const Point2& p = outline[left[j]];
    if (p != a && p != b && p != c && is_inside(p, a, b, c)) return false;
  }
  return true;
}

bool is_straight(const std::vector<Point2>& outline, const std::vector<std::uint32_t>& left, std::size_t i) {
  const std::size_t n = left.size();
  return turn_of(outline[left[(i + n - 1) % n]], outline[left[i]], outline[left[(i + 1) % n]]) == 0;
}

}  // namespace

double turn_of(const Point2& a, const Point2& b, const Point2& c) {
  return (double{b[0]} - a[0]) * (double{c[1]} - a[1]) - (double{b[1]} - a[1]) * (double{c[0]} - a[0]);
}

double signed_area(const std::vector<Point2>& outline) {
  double twice = 0;
  for (std::size_t i = 0; i < outline.size(); ++i)
    twice += turn_of(outline[0], outline[i], outline[(i + 1) % outline.size()]);
  return twice / 2;
}

std::optional<Triangles> triangulate(const std::vector<Point2>& outline) {
  std::vector<std::uint32_t> left(outline.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = static_cast<std::uint32_t>(i);
  Triangles triangles;
  while (left.size() >= 3) {
    std::size_t i = 0;
    while (i < left.size() && !is_ear(outline, left, i)) ++i;
    if (i < left.size()) {
      const std::size_t n = left.size();
      triangles.push_back({left[(i + n - 1) % n], left[i], left[(i + 1) % n]});
    } else {
      i = 0;
      while (i < left.size() && !is_straight(outline, left, i)) ++i;
      if (i == left.size()) return std::nullopt;
    }
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return triangles;
}

}  // namespace equilux
