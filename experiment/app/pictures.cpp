// Between the manifest and the graphics card.
#include "experiment/app/pictures.h"

#include <utility>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "stimuli/png_file.h"

namespace equilux {
namespace {

const PictureRecord& find_record(const StudyFolder& folder, const Manifest& manifest,
                                 const std::string& key) {
  const auto found = manifest.pictures.find(key);
  if (found == manifest.pictures.end())
    throw InputError(folder.manifest().string(), "/pictures", "the picture " + key, "none");
  return found->second;
}

void check_digest(const std::filesystem::path& path, const std::string& digest, const PictureRecord& record) {
  if (digest != record.digest) {
    throw InputError(path.string(), "", fmt::format("the digest {} of the manifest", record.digest),
                     digest + ": the picture was changed after it was made");
  }
}

}  // namespace

void check_pictures(const StudyFolder& folder, const Manifest& manifest,
                    const std::vector<std::string>& keys) {
  for (const std::string& key : keys) {
    const PictureRecord& record = find_record(folder, manifest, key);
    const std::filesystem::path path = folder.root / record.file;
    check_digest(path, digest_file(path), record);
  }
}

LdrImage load_picture(const StudyFolder& folder, const Manifest& manifest, const std::string& key) {
  const PictureRecord& record = find_record(folder, manifest, key);
  const std::filesystem::path path = folder.root / record.file;
  const std::string bytes = load_text(path);
  check_digest(path, digest_text(bytes), record);
  LdrImage image = decode_png(bytes, path.string());
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

std::vector<LdrImage> load_trial_images(const StudyFolder& folder, const Manifest& manifest,
                                        const TrialRow& trial) {
  std::vector<LdrImage> images;
  for (const std::string& key : list_keys_by_place(trial))
    images.push_back(load_picture(folder, manifest, key));
  return images;
}

TrialPictures upload_trial(const std::vector<LdrImage>& images) {
  TrialPictures pictures{Texture(images.at(0)), Texture(images.at(1)), std::nullopt};
  if (images.size() > 2) pictures.upper = Texture(images[2]);
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
