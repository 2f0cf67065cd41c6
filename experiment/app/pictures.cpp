// Between the manifest and the graphics card.
#include "experiment/app/pictures.h"

#include <utility>

#include "base/digest.h"
#include "base/error.h"
#include "stimuli/png_file.h"

namespace equilux {
namespace {

// The path of a picture whose bytes are those of the manifest.
std::filesystem::path find_picture(const StudyFolder& folder, const Manifest& manifest,
                                   const std::string& key) {
  const auto found = manifest.pictures.find(key);
  if (found == manifest.pictures.end()) {
    throw InputError(folder.manifest().string(), "/pictures", "the picture " + key, "none");
  }
  std::filesystem::path path = folder.root / found->second.file;
  const std::string digest = digest_file(path);
  if (digest != found->second.digest) {
    throw InputError(path.string(), "", fmt::format("the digest {} of the manifest", found->second.digest),
                     digest + ": the picture was changed after it was made");
  }
  return path;
}

}  // namespace

void check_pictures(const StudyFolder& folder, const Manifest& manifest,
                    const std::vector<std::string>& keys) {
  for (const std::string& key : keys) find_picture(folder, manifest, key);
}

LdrImage load_picture(const StudyFolder& folder, const Manifest& manifest, const std::string& key) {
  const std::filesystem::path path = find_picture(folder, manifest, key);
  LdrImage image = load_png(path);
  if (image.width != manifest.width || image.height != manifest.height) {
    throw InputError(path.string(), "", fmt::format("{} x {} pixels", manifest.width, manifest.height),
                     fmt::format("{} x {}", image.width, image.height));
  }
  return image;
}

std::vector<std::string> list_keys_by_place(const TrialRow& trial) {
  std::vector<std::string> keys{trial.test_key, trial.pair_key};
  if (trial.test_side == Side::kRight) std::swap(keys[0], keys[1]);
  if (!trial.upper_key.empty()) keys.push_back(trial.upper_key);
  return keys;
}

TrialPictures load_trial_pictures(const StudyFolder& folder, const Manifest& manifest,
                                  const TrialRow& trial) {
  const auto keys = list_keys_by_place(trial);
  const auto load = [&](const std::string& key) { return Texture(load_picture(folder, manifest, key)); };
  TrialPictures pictures{load(keys[0]), load(keys[1]), std::nullopt};
  if (keys.size() > 2) pictures.upper = load(keys[2]);
  return pictures;
}

FamiliarPictures load_familiar_pictures(const StudyFolder& folder, const Manifest& manifest,
                                        const FamiliarPage& page) {
  FamiliarPictures pictures{Texture(load_picture(folder, manifest, page.left_key)), std::nullopt};
  if (!page.right_key.empty()) pictures.right = Texture(load_picture(folder, manifest, page.right_key));
  return pictures;
}

void draw_pictures(const FamiliarPictures& pictures, const Layout& layout) {
  if (pictures.right) {
    pictures.left.draw(layout.left, layout.framebuffer);
    pictures.right->draw(layout.right, layout.framebuffer);
  } else {
    pictures.left.draw(find_middle(layout), layout.framebuffer);
  }
}

void draw_pictures(const TrialPictures& pictures, const Layout& layout) {
  pictures.left.draw(layout.left, layout.framebuffer);
  pictures.right.draw(layout.right, layout.framebuffer);
  EQ_CHECK(pictures.upper.has_value() == layout.upper.has_value());
  if (pictures.upper) pictures.upper->draw(*layout.upper, layout.framebuffer);
}

}  // namespace equilux
