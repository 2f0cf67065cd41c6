// The main proof: with full emission the unclamped VPL sum's expectation is the path tracer's.
#include "renderer/proof.h"

#include <boost/math/distributions/normal.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/renderer/test_scene.h"

namespace equilux {
namespace {

Scene proof_room() {
  return load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/proof-room.json");
}

// Two-sided p of a difference, by the normal: the sets of a proof are at least 128.
double p_of(const ProofEstimate& difference) {
  const double z = std::abs(difference.mean / difference.standard_error);
  return 2 * boost::math::cdf(boost::math::complement(boost::math::normal(), z));
}

// A bias of 3.86 standard errors is seen with 90 % power at level 1 %.
constexpr double kErrorsToSee = 3.86;

Proof prove_one(const Scene& scene, const MaterialSpec& material, const ProofParams& params) {
  return make_proofs(scene, {material}, params).front();
}

// The more an object reflects into itself, the wider its own VPLs' part is spread.
struct ProofCase {
  const char* geometry;
  int own_sets;
  std::vector<const char*> materials;
  double seen_on_ms =
      .005;  ///< bias found with 90 % power at level 1 %, relative; on the others half a per cent
};

// What stands beside a test's name in a list of tests.
void PrintTo(const ProofCase& how, std::ostream* stream) { *stream << how.geometry; }

// Half a per cent is seen for every material and geometry (checked), but six tenths for MS on G3, where
// smooth metal mirrors itself: rare paths between narrow lobes carry so much that more sets hardly narrow the
// spread. Seed 1, 288 VPL sets of 4,000 particles shared by the materials, and more of those that met the
// object; level 1 % over all 26 cases.
class ProofRoom : public testing::TestWithParam<ProofCase> {};

TEST_P(ProofRoom, UnclampedSumsWithFullEmissionAgreeWithThePathTracer) {
  const ProofCase& how = GetParam();
  const Scene scene = proof_room();
  ProofParams params;
  params.geometry = how.geometry;
  params.own_sets = how.own_sets;
  params.sets = 288;
  params.with_gap = false;
  params.camera_paths = 256;
  std::vector<MaterialSpec> materials;
  for (const char* name : how.materials) materials.push_back(find_material(scene, name));
  const auto proofs = make_proofs(scene, materials, params);
  for (std::size_t i = 0; i < proofs.size(); ++i) {
    const ProofEstimate difference = find_relative_difference(proofs[i].full, proofs[i].paths);
    const std::string text = fmt::format("{:.5f} +- {:.5f}", difference.mean, difference.standard_error);
    EXPECT_GT(p_of(difference), .01 / 26) << how.materials[i] << ": " << text;
    const double seen = std::string(how.materials[i]) == "MS" ? how.seen_on_ms : .005;
    EXPECT_LT(kErrorsToSee * difference.standard_error, seen) << how.materials[i];
    RecordProperty(how.materials[i], text);
  }
}

std::string name_of(const testing::TestParamInfo<ProofCase>& row) { return row.param.geometry; }

const std::vector<const char*> kStudyMaterials{"LG", "GS", "BR", "MR", "BS", "MS"};
INSTANTIATE_TEST_SUITE_P(StudyMaterials, ProofRoom,
                         testing::Values(ProofCase{"G0", 64, kStudyMaterials},
                                         ProofCase{"G1", 1536, kStudyMaterials},
                                         ProofCase{"G2", 1280, kStudyMaterials},
                                         ProofCase{"G3", 6144, kStudyMaterials, .006}),
                         name_of);

INSTANTIATE_TEST_SUITE_P(OtherModels, ProofRoom,
                         testing::Values(ProofCase{"G2", 3072, {"MRward", "MRbounded"}}), name_of);

// Particles of the environment start on a disk across the world: the light that a ball gets by way of the
// floor below it is the path tracer's. Level 1 %; a bias of 2 % would be seen with 90 % power.
TEST(Proof, VplsOfAConstantEnvironmentAgreeWithThePathTracer) {
  test::SceneText text;
  text.meshes = R"([{"name":"ball","sphere":{"radius":0.5,"subdivisions":5}},
    {"name":"floor","quad":{"u":[4,0,0],"v":[0,4,0]}}])";
  text.instances = R"([{"mesh":"floor","material":"grey","at":[-2,-2,-1]}])";
  text.lights = R"([{"environment":{"radiance":[1,1,1]}}])";
  text.stand = "[0,0,-0.5]";
  text.camera = R"({"position":[0,-3,-0.3],"target":[0,0,0],"up":[0,0,1],"vertical_fov_degrees":25})";
  const Scene scene = test::make_scene(text);
  ProofParams params;
  params.contact_band = 0;
  const Proof proof = prove_one(scene, scene.materials[0], params);
  const auto difference = find_relative_difference(proof.full, proof.paths);
  EXPECT_GT(p_of(difference), .01) << difference.mean << " +- " << difference.standard_error;
  EXPECT_LT(difference.standard_error, .02 / 3.86);
}

// Mutant: without the glossy part of their emission the same VPLs fall short where the object mirrors itself.
TEST(Proof, AMutantThatEmitsByTheDiffusePartAloneIsCaught) {
  const Scene scene = test::make_metal_wall_scene();
  ProofParams params;
  params.sets = 64;
  params.contact_band = 0;
  const Proof proof = prove_one(scene, scene.materials[0], params);
  EXPECT_GT(p_of(find_relative_difference(proof.full, proof.paths)), .01);
  EXPECT_LT(find_relative_difference(proof.full, proof.paths).standard_error, .01);
  const ProofEstimate lambertian{proof.full.mean - proof.gap.mean, proof.full.standard_error};
  EXPECT_LT(p_of(find_relative_difference(lambertian, proof.paths)), 1e-6);
}

// Its threshold of the shadow rays' roulette is 0, whichever material comes first.
TEST(Proof, AMaterialThatSendsNoLightHasNoneByEitherWay) {
  test::SceneText text;
  text.materials = R"([{"name":"grey","model":"lambertian","rho_d":[0.5,0.5,0.5]},
    {"name":"black","model":"lambertian","rho_d":[0,0,0]}])";
  text.meshes = R"([{"name":"ball","sphere":{"radius":0.5,"subdivisions":3}},
    {"name":"wall","quad":{"u":[4,0,0],"v":[0,0,4]}}])";
  text.instances = R"([{"mesh":"wall","material":"grey","at":[-2,2,-2]}])";
  text.lights = R"([{"spot":{"position":[1.5,0,0],"target":[0.5,2,0],"inner_degrees":20,"outer_degrees":35,
      "intensity":[5,5,5]}}])";
  text.stand = "[0,0,-0.5]";
  const Scene scene = test::make_scene(text);
  ProofParams params;
  params.sets = params.own_sets = 32;
  params.vpl_paths = 200;
  params.camera_paths = 16;
  params.contact_band = 0;
  for (const std::size_t first : {0U, 1U}) {
    const auto proofs = make_proofs(scene, {scene.materials[first], scene.materials[1 - first]}, params);
    const Proof &grey = proofs[first], &black = proofs[1 - first];
    EXPECT_EQ(black.paths.mean, 0);
    EXPECT_EQ(black.full.mean, 0);
    EXPECT_EQ(black.full.standard_error, 0);
    EXPECT_GT(p_of(find_relative_difference(grey.full, grey.paths)), .01);
  }
}

}  // namespace
}  // namespace equilux
