// Sheets: which cell holds what, cells equal to their pictures, gaps, refusals.
#include "renderer/sheet.h"

#include <algorithm>
#include <functional>
#include <gtest/gtest.h>
#include <numeric>

#include "base/error.h"
#include "renderer/make_sheet.h"
#include "renderer/set.h"
#include "renderer/sheet_cells.h"
#include "renderer/sheet_html.h"
#include "stimuli/exr_file.h"
#include "stimuli/png_file.h"
#include "tests/renderer/tiny_study.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

Study load_protocol(const std::string& name) {
  return load_study(fs::path(EQUILUX_SOURCE_DIR) / "protocols" / (name + ".json"));
}

std::string find_refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// A rendered tiny study and sheets of it.
class RenderedStudy {
 public:
  explicit RenderedStudy(const std::string& only = "*", const std::string& variant = "") : study_(variant) {
    make_set({study_.path(), folder(), only});
  }
  fs::path folder() const { return study_.folder() / "set"; }
  fs::path out() const { return study_.folder() / "sheet.png"; }
  fs::path html() const { return study_.folder() / "sheet.html"; }
  LdrImage picture(const std::string& key) const { return load_png(folder() / "pictures" / (key + ".png")); }
  SheetRequest request(SheetKind kind) const {
    SheetRequest request;
    request.folder = folder();
    request.out = out();
    request.params.kind = kind;
    return request;
  }

 private:
  test::TinyStudy study_;
};

// Where the grid of a sheet stands, by the same measure of text.
PageGrid find_grid(const RenderedStudy& study, const SheetRequest& request, int width, int height) {
  const Sheet sheet = make_sheet_layout(open_sheet_source(study.folder()).study, request.params);
  const ScaleBar scale = make_scale_bar(sheet.kind, request.scale, std::max(width, 160));
  return make_page_grid(sheet, width, height, scale, load_sheet_image().measure_text);
}

LdrImage cut_cell(const LdrImage& sheet, const PageGrid& grid, int row, int column) {
  LdrImage cell(grid.cell_width, grid.cell_height);
  for (int y = 0; y < cell.height; ++y) {
    const auto from = sheet.values.begin() + 3 * ((grid.top + row * grid.pitch_y + y) * sheet.width +
                                                  grid.left + column * grid.pitch_x);
    std::copy(from, from + 3 * cell.width, cell.values.begin() + 3 * y * cell.width);
  }
  return cell;
}

TEST(Sheet, OfClampsHasAColumnForEachCountAndTheReferenceLastAndNoClampAtTheBottom) {
  for (const auto& [name, counts] : {std::pair{"pocket", 2u}, std::pair{"paper", 3u}}) {
    const Sheet sheet = make_sheet_layout(load_protocol(name), {});
    ASSERT_EQ(sheet.columns.size(), counts + 1) << name;
    ASSERT_EQ(sheet.rows.size(), 11u) << name;
    EXPECT_EQ(sheet.cells.size(), 11 * (counts + 1)) << name;
    EXPECT_EQ(sheet.rows.front().name, "C10");
    EXPECT_EQ(sheet.rows.back().name, "C0");
    EXPECT_EQ(sheet.rows.back().note, "no clamp");
    EXPECT_EQ(sheet.rows[6].note, "c = 10");
    EXPECT_EQ(sheet.columns.front(), "1k VPLs");
    EXPECT_EQ(sheet.columns.back(), "reference");
    EXPECT_EQ(sheet.cell(10, 0).key, "G0-MS-ind-1k-C0-v0");
    EXPECT_EQ(sheet.cell(3, counts).key, "G0-MS-ind-ref-v0");
  }
}

TEST(Sheet, OfChosenLevelsAndCountsKeepsTheirOrder) {
  SheetParams params;
  params.object = "G3-BR-dir";
  params.view = 1;
  params.clamp_levels = {4, 0, 2};
  params.vpl_counts = {5000000, 1000};
  const Sheet sheet = make_sheet_layout(load_protocol("paper"), params);
  ASSERT_EQ(sheet.cells.size(), 9u);
  EXPECT_EQ(sheet.cell(0, 0).key, "G3-BR-dir-1k-C4-v1");
  EXPECT_EQ(sheet.cell(2, 1).key, "G3-BR-dir-5M-C0-v1");
}

TEST(Sheet, OfReferencesHasGeometriesByMaterials) {
  SheetParams params;
  params.kind = SheetKind::kReferences;
  params.illumination = Illumination::kDirectAndIndirect;
  const Sheet sheet = make_sheet_layout(load_protocol("paper"), params);
  EXPECT_EQ(sheet.columns, (std::vector<std::string>{"MS", "MR", "BS", "BR", "GS"}));
  ASSERT_EQ(sheet.rows.size(), 4u);
  EXPECT_EQ(sheet.cell(2, 3).key, "G2-BR-dir-ref-v0");
  params.illumination.reset();
  EXPECT_EQ(make_sheet_layout(load_protocol("pocket"), params).cells.size(), 4u);
  // One material of its own, four more from which artifact trials draw a reference.
  EXPECT_EQ(make_sheet_layout(load_protocol("normalisation"), params).columns.size(), 5u);
}

TEST(Sheet, OfNormalisedPicturesNamesThem) {
  const Sheet sheet = make_sheet_layout(load_protocol("normalisation"), {});
  EXPECT_EQ(sheet.rows[6].name, "C4n");
  EXPECT_EQ(sheet.cell(6, 1).key, "G0-MR-ind-100k-C4n-v0");
}

TEST(Sheet, OfWhatTheStudyLacksSaysWhatItHas) {
  const Study study = load_protocol("pocket");
  SheetParams object, counts, light;
  object.object = "G9-MS-ind";
  counts.vpl_counts = {5000000};
  light.kind = SheetKind::kError;
  light.illumination = Illumination::kDirectAndIndirect;
  EXPECT_EQ(find_refusal([&] { make_sheet_layout(study, object); }),
            "--object: expected one of G0-MS-ind, G0-GS-ind, G2-MS-ind, G2-GS-ind, got G9-MS-ind");
  EXPECT_EQ(find_refusal([&] { make_sheet_layout(study, counts); }),
            "--vpls: expected some of 1k, 100k, got 5M");
  EXPECT_EQ(find_refusal([&] { make_sheet_layout(study, light); }),
            "--illumination: expected some of ind, got dir");
}

TEST(Sheet, ColoursAndCutsAreWhatTheySay) {
  LdrImage all(16, 16);
  for (std::size_t i = 0; i < all.values.size(); ++i) all.values[i] = static_cast<std::uint8_t>(i / 3);
  EXPECT_EQ(to_display(to_linear(all)), all);
  const LdrImage same = show_difference(measure_difference(all, all), 32);
  EXPECT_TRUE(std::all_of(same.values.begin(), same.values.end(), [](int value) { return value == 221; }));
  HdrImage steps(2, 1, 1);
  steps.values = {-40, 40};
  const LdrImage ends = show_difference(steps, 32);
  EXPECT_GT(ends.values[2], ends.values[0]);  // blue where darker
  EXPECT_GT(ends.values[3], ends.values[5]);  // red where brighter
  HdrImage coverage(80, 40, 1);
  coverage.values[80 * 10 + 79] = 0.1f;
  coverage.values[80 * 12 + 70] = 1;
  EXPECT_EQ(find_object_box(coverage), (Crop{70, 10, 10, 3}));
  const auto crops = make_crops({find_object_box(coverage), {20, 20, 6, 8}}, 80, 40);
  EXPECT_EQ(crops[0], (Crop{66, 5, 14, 12}));  // moved back into the picture
  EXPECT_EQ(crops[1], (Crop{16, 18, 14, 12}));
}

TEST(Sheet, HoldsThePicturesBitByBit) {
  const RenderedStudy study;
  SheetRequest request = study.request(SheetKind::kClamp);
  request.params.clamp_levels = {0, 4};
  request.html = study.html();
  const SheetSummary summary = make_sheet(request);
  EXPECT_EQ(summary.pictures, 4u);
  EXPECT_EQ(summary.missing, 0u);
  const LdrImage sheet = load_png(study.out());
  EXPECT_EQ(sheet.width, summary.width);
  const PageGrid grid = find_grid(study, request, 24, 18);
  EXPECT_EQ(cut_cell(sheet, grid, 0, 0), study.picture("G0-MS-ind-100-C4-v0"));
  EXPECT_EQ(cut_cell(sheet, grid, 1, 0), study.picture("G0-MS-ind-100-C0-v0"));
  EXPECT_EQ(cut_cell(sheet, grid, 1, 1), study.picture("G0-MS-ind-ref-v0"));
  const std::string page = load_text(study.html());
  EXPECT_TRUE(mentions(page, "href=\"set/pictures/G0-MS-ind-100-C4-v0.png\""));
  EXPECT_TRUE(mentions(page, "<small>no clamp</small>"));
}

TEST(Sheet, IsDrawnWithTextAndTwiceTheSame) {
  const RenderedStudy study("G0-MS-ind-ref-v0");
  const SheetRequest request = study.request(SheetKind::kReferences);
  make_sheet(request);
  const LdrImage sheet = load_png(study.out());
  // Between the upper edge and the cells nothing but the title and labels is dark.
  const std::ptrdiff_t above = 3 * sheet.width * find_grid(study, request, 24, 18).top;
  EXPECT_GT(std::count_if(sheet.values.begin(), sheet.values.begin() + above, [](int v) { return v < 128; }),
            300);
  make_sheet(request);
  EXPECT_EQ(load_png(study.out()), sheet);
}

TEST(Sheet, IsShrunkInLinearLight) {
  const RenderedStudy study("G0-MS-ind-*");
  SheetRequest request = study.request(SheetKind::kClamp);
  request.params.clamp_levels = {0};
  request.cell_width = 8;
  make_sheet(request);
  const LdrImage small = cut_cell(load_png(study.out()), find_grid(study, request, 8, 6), 0, 1);
  const auto mean = [](const LdrImage& picture) {
    const HdrImage linear = to_linear(picture);
    return std::accumulate(linear.values.begin(), linear.values.end(), 0.0) / double(linear.values.size());
  };
  const double whole = mean(study.picture("G0-MS-ind-ref-v0"));
  EXPECT_NEAR(mean(small), whole, 0.05 * whole);
  request.cell_width = 500;  // never enlarged
  make_sheet(request);
  EXPECT_EQ(cut_cell(load_png(study.out()), find_grid(study, request, 24, 18), 0, 1),
            study.picture("G0-MS-ind-ref-v0"));
}

TEST(Sheet, LeavesACellEmptyWhosePictureIsMissing) {
  const RenderedStudy study;
  fs::remove(study.folder() / "pictures/G0-MS-ind-100-C4-v0.png");
  SheetRequest request = study.request(SheetKind::kClamp);
  request.params.clamp_levels = {4};
  request.html = study.html();
  const SheetSummary summary = make_sheet(request);
  EXPECT_EQ(summary.pictures, 1u);
  EXPECT_EQ(summary.missing, 1u);
  const LdrImage cell = cut_cell(load_png(study.out()), find_grid(study, request, 24, 18), 0, 0);
  EXPECT_TRUE(std::equal(cell.values.begin(), cell.values.begin() + 9, std::vector<int>(9, 240).begin()));
  EXPECT_TRUE(mentions(load_text(study.html()), "not rendered"));
}

TEST(Sheet, OfDifferencesIsGreyOutsideTheObject) {
  const RenderedStudy study;
  SheetRequest request = study.request(SheetKind::kDifference);
  request.params.clamp_levels = {10};
  request.html = study.html();
  make_sheet(request);
  const PageGrid grid = find_grid(study, request, 24, 18);
  const LdrImage sheet = load_png(study.out());
  const LdrImage cell = cut_cell(sheet, grid, 0, 0);
  const HdrImage coverage = load_exr(study.folder() / "layers/G0-MS-ind-ref-v0.coverage.exr").image;
  int differing = 0;
  for (std::size_t i = 0; i < coverage.values.size(); ++i) {
    const bool grey =
        std::all_of(&cell.values[3 * i], &cell.values[3 * i] + 3, [](int v) { return v == 221; });
    if (coverage.values[i] == 0) {
      EXPECT_TRUE(grey) << i;
    }
    differing += !grey;
  }
  EXPECT_GT(differing, 10);
  EXPECT_EQ(cut_cell(sheet, grid, 0, 1), study.picture("G0-MS-ind-ref-v0"));
  EXPECT_TRUE(mentions(load_text(study.html()), "data:image/png;base64,iVBORw0KGgo"));
}

TEST(Sheet, OfErrorsReadsTheLayers) {
  const RenderedStudy study;
  SheetRequest request = study.request(SheetKind::kError);
  EXPECT_EQ(make_sheet(request).pictures, 2u);
  Manifest manifest = load_manifest(study.folder() / "manifest.json");
  const Manifest whole = manifest;
  manifest.tones.at("G0-GS-ind-ref-v0").tone_operator = "local";
  save_manifest(manifest, study.folder() / "manifest.json");
  EXPECT_TRUE(mentions(find_refusal([&] { make_sheet(request); }),
                       "/tones: expected the study's operator, global, got local"));
  save_manifest(whole, study.folder() / "manifest.json");
  fs::remove(study.folder() / "layers/G0-GS-ind-ref-v0.standard_error.exr");
  EXPECT_TRUE(mentions(find_refusal([&] { make_sheet(request); }), "G0-GS-ind-ref-v0.standard_error.exr"));
}

TEST(Sheet, WithoutAnyPictureSaysWhatMakesThem) {
  const RenderedStudy study("G0-GS-ind-ref-v0");
  const std::string refusal = find_refusal([&] { make_sheet(study.request(SheetKind::kClamp)); });
  EXPECT_TRUE(mentions(refusal, study.folder().string())) << refusal;
  EXPECT_TRUE(mentions(refusal, "equilux-render set")) << refusal;
  EXPECT_FALSE(fs::exists(study.out()));
}

TEST(Sheet, RefusesAPictureThatIsNotTheManifests) {
  const RenderedStudy study;
  save_png(study.picture("G0-MS-ind-100-C3-v0"), study.folder() / "pictures/G0-MS-ind-100-C8-v0.png");
  EXPECT_TRUE(mentions(find_refusal([&] { make_sheet(study.request(SheetKind::kClamp)); }),
                       "G0-MS-ind-100-C8-v0.png: expected the file recorded in manifest.json"));
}

TEST(Sheet, RefusesToStandAmongTheStudysOwnFiles) {
  const RenderedStudy study("G0-MS-ind-ref-v0");
  SheetRequest request = study.request(SheetKind::kReferences);
  fs::create_directory_symlink(study.folder() / "layers", study.folder() / "link");
  for (const char* name : {"pictures/sheet.png", "layers/sheet.png", "link/sheet.png", "manifest.json",
                           "../set/pictures/G0-MS-ind-ref-v0.png"}) {
    request.out = study.folder() / name;
    EXPECT_TRUE(mentions(find_refusal([&] { make_sheet(request); }), "--out")) << name;
  }
}

TEST(SheetHtml, EncodesPathsNamesAndBytes) {
  Sheet sheet;
  sheet.title = "a < b";
  sheet.columns = {"x"};
  sheet.rows = {{"y", ""}};
  sheet.cells = {{CellKind::kPicture, "key", {}}};
  const std::string page = format_sheet_html(sheet, {{{"a b#%/ü.png", "Ma", {0, 0, 4, 4}}}, 8, 4, 4, ""});
  EXPECT_TRUE(mentions(page, "<h1>a &#60; b</h1>"));
  EXPECT_TRUE(mentions(page, "href=\"a%20b%23%25/%C3%BC.png\""));
  EXPECT_TRUE(mentions(page, "base64,TWE=\""));
}

}  // namespace
}  // namespace equilux
