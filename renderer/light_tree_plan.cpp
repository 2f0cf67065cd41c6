#include "renderer/light_tree_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "renderer/parallel.h"

namespace equilux {
namespace {

constexpr std::uint32_t kMostRanges = 65536;
constexpr std::size_t kDimensions = 6;                           // of position and normal
constexpr std::size_t kMostBins = 32, kFewBins = 8, kFew = 128;  // bins, and ranges that few are enough for
constexpr float kNormalShare = 0.05f;

using Place = std::array<float, kDimensions>;

// Bounds of positions and normals, and the sum of weights.
struct Extent {
  Place low, high;
  double weight = 0;

  Extent() {
    low.fill(std::numeric_limits<float>::infinity());
    high.fill(-std::numeric_limits<float>::infinity());
  }

  void add(const Extent& other) {
    for (std::size_t k = 0; k < kDimensions; ++k) {
      low[k] = std::min(low[k], other.low[k]);
      high[k] = std::max(high[k], other.high[k]);
    }
    weight += other.weight;
  }
};

struct Range {
  std::uint32_t first, last;
  Extent extent;
  Place middle;
};

void find_ranges(const LargeArray<std::uint64_t>& keys, std::uint32_t first, std::uint32_t last,
                 std::uint32_t largest, std::vector<Range>& ranges) {
  if (last - first <= largest) {
    ranges.push_back({first, last, {}, {}});
    return;
  }
  const std::uint32_t middle = split_range(keys, first, last);
  find_ranges(keys, first, middle, largest, ranges);
  find_ranges(keys, middle, last, largest, ranges);
}

void measure_range(const VplList& sorted, Range& range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    const Vec3 p = sorted.vpls[i].p, ng = sorted.vpls[i].ng();
    Extent one;
    one.low = one.high = {p.x, p.y, p.z, ng.x, ng.y, ng.z};
    one.weight = weigh_vpl(sorted, i);
    range.extent.add(one);
  }
  for (std::size_t k = 0; k < kDimensions; ++k)
    range.middle[k] = 0.5f * (range.extent.low[k] + range.extent.high[k]);
}

class Planner {
 public:
  Planner(std::vector<Range> ranges, float size)
      : ranges_(std::move(ranges)), order_(ranges_.size()), normal_scale_(kNormalShare * size / 2) {
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.reserve(2 * ranges_.size());
  }

  std::vector<PlanNode> plan() {
    split(0, order_.size());
    return std::move(nodes_);
  }

 private:
  struct Cut {
    std::size_t dimension = kDimensions, bin = 0;  // the last bin of the left side
    double cost = std::numeric_limits<double>::infinity();
  };
  using Bins = std::array<Extent, kMostBins>;  // of one dimension

  std::uint32_t split(std::size_t first, std::size_t last) {
    const auto place = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    if (last - first == 1) {
      const Range& range = ranges_[order_[first]];
      nodes_[place] = {range.first, range.last, range.last - range.first, 0, 0};
      return place;
    }
    const std::size_t middle = find_middle(first, last);
    const std::uint32_t left = split(first, middle), right = split(middle, last);
    nodes_[place] = {0, 0, nodes_[left].count + nodes_[right].count, left, right};
    return place;
  }

  // Puts those of the left side in front. Ranges that no bin tells apart are halved.
  std::size_t find_middle(std::size_t first, std::size_t last) {
    Place low, high;
    low.fill(std::numeric_limits<float>::infinity());
    high.fill(-std::numeric_limits<float>::infinity());
    for (std::size_t i = first; i < last; ++i) {
      const Place& middle = ranges_[order_[i]].middle;
      for (std::size_t k = 0; k < kDimensions; ++k) {
        low[k] = std::min(low[k], middle[k]);
        high[k] = std::max(high[k], middle[k]);
      }
    }
    const std::size_t count = last - first < kFew ? kFewBins : kMostBins;
    Place scale;
    for (std::size_t k = 0; k < kDimensions; ++k)
      scale[k] = high[k] > low[k] ? static_cast<float>(count) / (high[k] - low[k]) : 0;
    const auto bin_of = [&](std::size_t range, std::size_t k) {
      const float bin = (ranges_[range].middle[k] - low[k]) * scale[k];
      return std::min(count - 1, static_cast<std::size_t>(bin));
    };
    Cut best;
    for (std::size_t k = 0; k < kDimensions; ++k) {
      if (!(scale[k] > 0)) continue;
      Bins bins;
      for (std::size_t i = first; i < last; ++i) bins[bin_of(order_[i], k)].add(ranges_[order_[i]].extent);
      search_cut(bins, count, k, best);
    }
    const std::size_t half = first + (last - first) / 2;
    if (best.dimension == kDimensions) return half;
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(first),
               end = order_.begin() + static_cast<std::ptrdiff_t>(last);
    const auto middle = std::stable_partition(
        begin, end, [&](std::uint32_t range) { return bin_of(range, best.dimension) <= best.bin; });
    return middle == begin || middle == end ? half : static_cast<std::size_t>(middle - order_.begin());
  }

  void search_cut(const Bins& bins, std::size_t count, std::size_t dimension, Cut& best) const {
    std::array<double, kMostBins> right_costs;
    Extent right;
    for (std::size_t i = count; i-- > 1;) {
      right.add(bins[i]);
      right_costs[i] = cost_of(right);
    }
    Extent left;
    for (std::size_t i = 0; i + 1 < count; ++i) {
      left.add(bins[i]);
      const double cost = cost_of(left) + right_costs[i + 1];
      if (cost < best.cost) best = {dimension, i, cost};
    }
  }

  // An empty side is no split.
  double cost_of(const Extent& extent) const {
    if (!(extent.high[0] >= extent.low[0])) return std::numeric_limits<double>::infinity();
    double square = 0;
    for (std::size_t k = 0; k < kDimensions; ++k) {
      const double wide = double{extent.high[k]} - extent.low[k],
                   scaled = k < 3 ? wide : wide * normal_scale_;
      square += scaled * scaled;
    }
    return extent.weight * std::sqrt(square);
  }

  std::vector<Range> ranges_;
  std::vector<std::uint32_t> order_;  // of ranges
  double normal_scale_;
  std::vector<PlanNode> nodes_;
};

}  // namespace

std::uint32_t split_range(const LargeArray<std::uint64_t>& keys, std::uint32_t first, std::uint32_t last) {
  const std::uint64_t differ = keys[first] ^ keys[last - 1];
  if (differ == 0) return first + (last - first) / 2;
  const std::uint64_t bit = 1ULL << (63 - std::countl_zero(differ));
  const auto found = std::partition_point(keys.begin() + first, keys.begin() + last,
                                          [&](std::uint64_t key) { return (key & bit) == 0; });
  return static_cast<std::uint32_t>(found - keys.begin());
}

std::vector<PlanNode> plan_tree(const VplList& sorted, const LargeArray<std::uint64_t>& keys,
                                std::uint32_t least, float size) {
  const auto count = static_cast<std::uint32_t>(keys.size());
  std::vector<Range> ranges;
  find_ranges(keys, 0, count, std::max(least, count / kMostRanges), ranges);
  for_each_parallel(ranges.size(), [&](std::size_t i) { measure_range(sorted, ranges[i]); });
  return Planner(std::move(ranges), size).plan();
}

}  // namespace equilux
