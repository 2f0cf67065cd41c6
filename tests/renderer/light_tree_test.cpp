// The light tree, its bounds, and the cut against the plain sum over all VPLs.
#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <set>

#include "base/random.h"
#include "renderer/light_tree_plan.h"
#include "renderer/lightcut.h"
#include "renderer/node_bounds.h"
#include "renderer/parallel.h"
#include "tests/renderer/test_scene.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

Vec3 draw_direction(RandomStream& random) {
  const float z = 2 * random.next_float() - 1, angle = 2 * kPi * random.next_float();
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Vec3 draw_point(RandomStream& random, float scale) {
  const auto draw = [&] { return scale * (2 * random.next_float() - 1); };
  return {draw(), draw(), draw()};
}

// VPLs in a few heaps, so that boxes and cones of every size occur; a third of them glossy if asked.
VplList draw_vpls(int count, std::uint64_t seed, bool glossy) {
  RandomStream random(seed, "vpls", 0);
  VplList list;
  Vec3 heap, facing{0, 0, 1}, coming{0, 0, 1};
  for (int i = 0; i < count; ++i) {
    if (i % 50 == 0) {
      heap = draw_point(random, 3);
      facing = draw_direction(random);
      coming = draw_direction(random);
    }
    const float spread = std::pow(10.0f, -4 * random.next_float());
    const Vec3 p = heap + draw_point(random, spread),
               ng = normalize(facing + draw_direction(random) * spread);
    const float red = random.next_float(), green = random.next_float();
    Vpl vpl(p, 0, ng, {red, green, 0.01f + random.next_float()});
    if (glossy && i % 3 == 0) {
      vpl.set_gloss(static_cast<std::int32_t>(list.gloss.size()));
      const Vec3 ns = normalize(ng + draw_direction(random) * 0.05f * spread);
      Vec3 wi = normalize(coming + draw_direction(random) * spread);
      if (dot(wi, ns) < 0) wi = -wi;
      const auto model = static_cast<GlossModel>(random.next_below(3));
      const float alpha = std::pow(10.0f, -4 * random.next_float());
      list.gloss.push_back({ns, wi, {0.5f, 0.2f, 0.1f}, alpha, model});
    }
    list.vpls.push_back(vpl);
  }
  return list;
}

// Calls check(node, VPL) for every VPL below every node, at most `most` for each.
template <typename Check>
void for_each_member(const LightTree& tree, std::uint32_t node, std::vector<std::uint32_t>& path,
                     const Check& check) {
  path.push_back(node);
  if (tree.nodes[node].leaf_count > 0) {
    for (std::uint32_t i = 0; i < tree.nodes[node].leaf_count; ++i) {
      for (std::uint32_t above : path) check(above, tree.nodes[node].next + i);
    }
  } else {
    for_each_member(tree, tree.nodes[node].next, path, check);
    for_each_member(tree, tree.nodes[node].next + 1, path, check);
  }
  path.pop_back();
}

class Trees : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(OfLeaves, Trees, testing::Values(1, 4, 8));

TEST_P(Trees, HoldEveryVplOnceWithinTheBoundsOfAllNodesAboveIt) {
  const VplList list = draw_vpls(5000, 1, true);
  const LightTree tree = make_light_tree(list, {7, GetParam()});
  ASSERT_EQ(tree.vpls.size(), list.size());
  std::vector<int> seen(list.size());
  std::vector<double> weights(tree.nodes.size());
  std::vector<std::uint32_t> path;
  for_each_member(tree, 0, path, [&](std::uint32_t node, std::uint32_t index) {
    const Vpl& vpl = tree.vpls.vpls[index];
    const Cluster cluster = unpack_cluster(tree, tree.nodes[node]);
    for (const auto& [low, p, high] : {std::array{cluster.low.x, vpl.p.x, cluster.high.x},
                                       {cluster.low.y, vpl.p.y, cluster.high.y},
                                       {cluster.low.z, vpl.p.z, cluster.high.z}}) {
      ASSERT_LE(low, p);
      ASSERT_GE(high, p);
    }
    ASSERT_GE(dot(cluster.axis, vpl.ng()), cluster.cos_angle - 1e-6f);
    weights[node] += weigh_vpl(tree.vpls, index);
    seen[index] += node == 0;
    if (vpl.gloss() < 0) return;
    const VplGloss& gloss = tree.vpls.gloss[static_cast<std::size_t>(vpl.gloss())];
    const auto angle = [](Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)); };
    const Vec3 mirror = normalize(gloss.ns * (2 * dot(gloss.ns, gloss.wi)) - gloss.wi);
    ASSERT_LE(angle(tree.gloss[node].ns, gloss.ns), tree.gloss[node].ns_angle + 5e-7f);
    ASSERT_LE(angle(tree.gloss[node].mirror, mirror), tree.gloss[node].mirror_angle + 5e-7f);
    ASSERT_GE(tree.gloss[node].alpha, gloss.alpha);
  });
  for (int count : seen) EXPECT_EQ(count, 1);
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    if (i == 1) continue;  // not used
    EXPECT_NEAR(tree.nodes[i].weight / weights[i], 1, 1e-5);
    EXPECT_LE(tree.nodes[i].leaf_count, GetParam());
    if (tree.nodes[i].leaf_count > 0) continue;
    EXPECT_EQ(tree.nodes[tree.nodes[i].next].representative, tree.nodes[i].representative);
  }
}

TEST(LightTree, IsTheSameOnOneAndTwoThreadsAndAnotherForAnotherSeed) {
  const VplList list = draw_vpls(5000, 2, false);
  const auto representatives = [&](std::uint64_t seed, int threads) {
    const ThreadLimit limit(threads);
    std::vector<std::uint32_t> found;
    for (const LightNode& node : make_light_tree(list, {seed, 2}).nodes) {
      found.push_back(node.representative);
      found.push_back(node.next);
    }
    return found;
  };
  EXPECT_EQ(representatives(1, 1), representatives(1, 2));
  EXPECT_NE(representatives(1, 1), representatives(2, 1));
}

double sum_extents(const VplList& list, const std::vector<std::vector<std::uint32_t>>& clusters) {
  double sum = 0;
  for (const auto& cluster : clusters) {
    Vec3 low = list.vpls[cluster[0]].p, high = low;
    for (std::uint32_t i : cluster) {
      const Vec3 p = list.vpls[i].p;
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    sum += static_cast<double>(cluster.size()) * length(high - low);
  }
  return sum;
}

// Keys that sort by x alone cut 64 slabs; 64 clusters of the plan over the same ranges are far smaller.
TEST(LightTreePlan, FindsSplitsThatMakeExtentsSmall) {
  RandomStream random(9, "plan", 0);
  VplList list;
  for (int i = 0; i < 4096; ++i) list.vpls.push_back(Vpl(draw_point(random, 2), 0, {0, 0, 1}, {1, 1, 1}));
  std::sort(list.vpls.begin(), list.vpls.end(), [](const Vpl& a, const Vpl& b) { return a.p.x < b.p.x; });
  LargeArray<std::uint64_t> keys;
  for (std::uint64_t i = 0; i < 4096; ++i) keys.push_back(i);
  const std::vector<PlanNode> plan = plan_tree(list, keys, 1, 7);
  EXPECT_EQ(plan.size(), 2 * 4096u - 1);
  std::vector<std::uint32_t> nodes{0};
  while (nodes.size() < 64) {
    std::vector<std::uint32_t> next;
    for (std::uint32_t node : nodes) {
      ASSERT_EQ(plan[node].count, plan[plan[node].left].count + plan[plan[node].right].count);
      next.push_back(plan[node].left);
      next.push_back(plan[node].right);
    }
    nodes = next;
  }
  std::vector<std::vector<std::uint32_t>> found(64), slabs(64);
  const auto collect = [&](const auto& self, std::uint32_t node,
                           std::vector<std::uint32_t>& cluster) -> void {
    if (plan[node].is_range()) return cluster.push_back(plan[node].first);
    self(self, plan[node].left, cluster);
    self(self, plan[node].right, cluster);
  };
  std::size_t all = 0;
  for (std::size_t i = 0; i < 64; ++i) {
    collect(collect, nodes[i], found[i]);
    all += found[i].size();
    for (std::uint32_t k = 0; k < 64; ++k) slabs[i].push_back(static_cast<std::uint32_t>(64 * i) + k);
  }
  EXPECT_EQ(all, 4096u);
  // Cubes have a diagonal of 1.7 sides of 1 m, slabs one of 5.7 m.
  EXPECT_LT(sum_extents(list, found), 0.4 * sum_extents(list, slabs));
}

// Cuts of large clusters read what lies in front: children of larger nodes come before those of smaller ones,
// and the VPLs that stand for large nodes before the others.
TEST(LightTree, LiesInMemoryBySize) {
  const LightTree tree = make_light_tree(draw_vpls(50000, 4, false), {1, 2});
  std::vector<std::uint32_t> counts(tree.nodes.size()), path;
  for_each_member(tree, 0, path, [&](std::uint32_t node, std::uint32_t) { ++counts[node]; });
  std::vector<std::uint32_t> parents(tree.nodes.size());
  for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
    if (i == 1 || tree.nodes[i].leaf_count > 0) continue;
    EXPECT_EQ(tree.nodes[i].next % 2, 0u);
    parents[tree.nodes[i].next] = parents[tree.nodes[i].next + 1] = i;
  }
  const auto size_class = [](std::uint32_t count) { return count >= 64 ? 2 : count >= 8 ? 1 : 0; };
  for (std::size_t i = 4; i < tree.nodes.size(); i += 2)
    ASSERT_LE(size_class(counts[parents[i]]), size_class(counts[parents[i - 2]])) << i;
  std::size_t large = 0;
  std::uint32_t furthest = 0;
  for (std::size_t i = 2; i < tree.nodes.size(); ++i) {
    if (counts[i] < 64) continue;
    ++large;
    furthest = std::max(furthest, tree.nodes[i].representative);
  }
  EXPECT_GT(large, 300u);
  EXPECT_LT(furthest, 2 * large);  // leaves of two
}

// Of the root, over 4,000 seeds, in proportion to weights that go from 1 to 16. Level .001.
TEST(LightTree, DrawsRepresentativesInProportionToTheirWeights) {
  VplList list;
  for (int i = 0; i < 16; ++i) {
    const float intensity = static_cast<float>(i + 1);
    list.vpls.push_back({{static_cast<float>(i % 4), static_cast<float>(i / 4), 0},
                         0,
                         {0, 0, 1},
                         {intensity, intensity, intensity}});
  }
  std::vector<double> counts(16), expected(16);
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const LightTree tree = make_light_tree(list, {seed, 1});
    const Vpl& vpl = tree.vpls.vpls[tree.nodes[0].representative];
    ++counts[static_cast<std::size_t>(std::lround(vpl.intensity.x)) - 1];
  }
  for (std::size_t i = 0; i < 16; ++i) expected[i] = 4000.0 * static_cast<double>(i + 1) / 136;
  EXPECT_GT(test::test_chi_squared(counts, expected).p, 0.001);
}

TEST(LightTree, OfNoneOneAndEqualVplsIsWhole) {
  EXPECT_TRUE(make_light_tree({}, {}).empty());
  VplList list;
  for (int count : {1, 2, 100}) {
    list.vpls.assign(static_cast<std::size_t>(count), Vpl({1, 2, 3}, 0, {0, 1, 0}, {1, 1, 1}));
    const LightTree tree = make_light_tree(list, {});
    EXPECT_EQ(tree.nodes.size(), static_cast<std::size_t>(2 * count));
    const Cluster cluster = unpack_cluster(tree, tree.nodes[0]);
    EXPECT_EQ(cluster.low, (Vec3{1, 2, 3}));
    EXPECT_NEAR(tree.nodes[0].weight, static_cast<float>(count), 1e-3f);
  }
}

TEST(Octahedral, VectorsComeBackWithinTheirError) {
  RandomStream random(3, "octahedral", 0);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const Vec3 unit = draw_direction(random), back = decode_octahedral(encode_octahedral(unit));
    worst = std::max(worst, double{length(cross(unit, back))});
    ASSERT_NEAR(length(back), 1, 1e-6);
  }
  EXPECT_LT(worst, kOctahedralError);
  for (Vec3 axis : {Vec3{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}})
    EXPECT_EQ(decode_octahedral(encode_octahedral(axis)), axis);
}

Material draw_material(RandomStream& random) {
  MaterialSpec spec{"drawn", {random.next_float() * 0.5f, 0.1f, 0.2f}, {}, 0};
  if (random.next_below(4) > 0) {
    spec.rho_s = {0.4f * random.next_float(), 0.3f, 0.1f};
    spec.roughness_alpha = std::pow(10.0f, -4 * random.next_float());
    spec.model = static_cast<GlossModel>(random.next_below(3));
  }
  return make_material(spec);
}

// A point of the object anywhere, also in the middle of VPLs, seen from anywhere above its horizon, often at
// grazing angles.
ShadingPoint draw_shading_point(RandomStream& random, const LightTree& tree) {
  ShadingPoint point;
  const Vpl& near = tree.vpls.vpls[random.next_below(tree.vpls.size())];
  const float away = std::pow(10.0f, 1 - 6 * random.next_float());
  Vec3 towards = draw_direction(random);
  if (near.gloss() >= 0 && random.next_below(2) == 0) {
    const VplGloss& gloss = tree.vpls.gloss[static_cast<std::size_t>(near.gloss())];
    const Vec3 mirror = gloss.ns * (2 * dot(gloss.ns, gloss.wi)) - gloss.wi;
    towards = normalize(mirror + towards * (2 * gloss.alpha));
  }
  point.surface.p = near.p + towards * away;
  point.surface.ns = point.surface.ng = draw_direction(random);
  const Frame frame(point.surface.ns);
  const float z = random.next_below(2) == 0 ? random.next_float() : 1e-3f * random.next_float();
  const float angle = 2 * kPi * random.next_float(), r = std::sqrt(1 - z * z);
  point.v = normalize(frame.to_world({r * std::cos(angle), r * std::sin(angle), z}));
  return point;
}

// The light of each VPL below a node, by the BRDF's own functions, against the node's bound.
// shape: trees x points x nodes x members x materials x levels; seed 5.
TEST(ClusterBounds, HoldForEveryMemberPointMaterialAndLevel) {
  std::int64_t cases = 0, violations = 0;
  double tightest = 0, furthest = 0, cosines_apart = 0;
  constexpr float kUnclamped = std::numeric_limits<float>::infinity();
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const LightTree tree = make_light_tree(draw_vpls(600, seed, seed % 2 == 0), {seed, 1});
    RandomStream random(5, "bounds", seed);
    for (int k = 0; k < 120; ++k) {
      const ShadingPoint point = draw_shading_point(random, tree);
      const BoundPoint bound_point = make_bound_point(point);
      const Material material = draw_material(random);
      std::vector<std::uint32_t> path;
      std::vector<BoxSight> sights;
      std::vector<float> most_m, emission, lane_peaks;
      for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
        const Cluster cluster = unpack_cluster(tree, tree.nodes[i]);
        sights.push_back(sight_box(bound_point, cluster.low, cluster.high));
        most_m.push_back(bound_material(material, bound_point, sights.back()));
        emission.push_back(
            bound_emission(point.surface.p, cluster, tree.gloss.empty() ? nullptr : &tree.gloss[i]));
      }
      // The lanes' code is its own: it is held to the members too, by being put in the scalar one's place.
      if (k % 2 == 1) {
        for (std::uint32_t first = 0; first < tree.nodes.size(); first += kNodeLanes) {
          std::array<std::uint32_t, kNodeLanes> ids{};
          const std::size_t count = std::min<std::size_t>(kNodeLanes, tree.nodes.size() - first);
          for (std::uint32_t lane = 0; lane < count; ++lane) ids[lane] = first + lane;
          const NodeBounds bounds = bound_nodes(tree, material, bound_point, ids.data(), count);
          for (std::size_t lane = 0; lane < count; ++lane) {
            const std::size_t i = first + lane;
            const float scalar = bound_transfer(most_m[i], sights[i].least_r2, kUnclamped);
            // Of narrower lobes the exponential makes much of the last bit. At the horizon a bound without
            // gloss is a cosine, and nothing but its rounding.
            const float diffuse = max_component(material.rho_d) * kInvPi * sights[i].most_cos;
            const bool wide = material.alpha == 0 || material.alpha > 0.01f,
                       grazing = diffuse > 0.99f * most_m[i] && sights[i].most_cos < 1e-4f;
            if (wide && std::isfinite(scalar) && scalar > 1e-30f && bounds.peak[lane] > 1e-30f) {
              if (grazing) {
                cosines_apart = std::max(
                    cosines_apart, sights[i].most_cos * std::abs(double{bounds.peak[lane]} / scalar - 1));
              } else {
                furthest = std::max(furthest, std::abs(std::log(double{bounds.peak[lane]} / scalar)));
              }
            }
            lane_peaks.push_back(bounds.peak[lane]);
            // Where nothing is reflected the lanes give no emission, which is not asked for then.
            if (bounds.peak[lane] > 0) emission[i] = bounds.emission[lane];
          }
        }
      }
      std::vector<double> sums(tree.nodes.size());
      for_each_member(tree, 0, path, [&](std::uint32_t node, std::uint32_t index) {
        const Vpl& vpl = tree.vpls.vpls[index];
        const Vec3 d = vpl.p - point.surface.p;
        const float r2 = dot(d, d);
        if (!(r2 > 0)) return;
        const Vec3 l = d / std::sqrt(r2), local = bound_point.shading.to_local(l);
        const float cos_vpl = -dot(vpl.ng(), l);
        if (!(local.z > 0) || !(cos_vpl > 0)) return;
        const float m = max_component(eval_brdf(material, bound_point.v, local) * local.z);
        Vec3 light = vpl.intensity * cos_vpl;
        if (vpl.gloss() >= 0) {
          const VplGloss& gloss = tree.vpls.gloss[static_cast<std::size_t>(vpl.gloss())];
          Material emitting;
          emitting.alpha = gloss.alpha;
          emitting.model = gloss.model;
          const Frame frame(gloss.ns);
          light +=
              gloss.flux * (eval_glossy(emitting, frame.to_local(gloss.wi), frame.to_local(-l)) * cos_vpl);
        }
        sums[node] += luminance(light);
        for (const float clamp : {0.01f, 10.0f, kUnclamped}) {
          const float value = std::min(clamp, m / r2),
                      bound = lane_peaks.empty() ? bound_transfer(most_m[node], sights[node].least_r2, clamp)
                                                 : std::min(clamp, lane_peaks[node]);
          ++cases;
          violations += !(value <= bound);
          if (bound > 0 && std::isfinite(bound)) tightest = std::max(tightest, double{value} / bound);
        }
      });
      for (std::size_t i = 0; i < sums.size(); ++i) {
        ++cases;
        violations += !(sums[i] <= emission[i]);
      }
    }
  }
  EXPECT_EQ(violations, 0) << "of " << cases;
  EXPECT_GT(cases, 10000000);
  EXPECT_LT(furthest, 0.005) << "the two codes' bounds are nearly one";
  EXPECT_LT(cosines_apart, 1e-7) << "at the horizon to float's last bit";
  EXPECT_GT(tightest, 0.999) << "bounds of single VPLs are nearly exact";
}

}  // namespace
}  // namespace equilux
