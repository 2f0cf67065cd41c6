// The pictures of a trial, checked against the manifest before they are shown.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiment/app/texture.h"
#include "experiment/extra_trials.h"
#include "experiment/trial_log.h"
#include "stimuli/manifest.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// Checks that the files of these pictures are those of the manifest, so that a session does not break off in
/// its middle. errors: InputError
void check_pictures(const StudyFolder& folder, const Manifest& manifest,
                    const std::vector<std::string>& keys);

/// errors: InputError for a picture that is not in the manifest, has another digest or another size.
LdrImage load_picture(const StudyFolder& folder, const Manifest& manifest, const std::string& key);

/// Keys of a trial's pictures by their places: left, right and, where there is one, above. They are read in
/// this order, whichever is the test picture.
std::vector<std::string> list_keys_by_place(const TrialRow& trial);

/// A trial's pictures, ready to be drawn.
struct TrialPictures {
  Texture left;
  Texture right;
  std::optional<Texture> upper;
};

/// A page of the familiarisation, ready to be drawn.
struct FamiliarPictures {
  Texture left;
  std::optional<Texture> right;  ///< without it the left one stands in the middle
};

FamiliarPictures load_familiar_pictures(const StudyFolder& folder, const Manifest& manifest,
                                        const FamiliarPage& page);

void draw_pictures(const FamiliarPictures& pictures, const Layout& layout);

/// A trial's pictures by their places, from any thread. errors: as load_picture
std::vector<LdrImage> load_trial_images(const StudyFolder& folder, const Manifest& manifest,
                                        const TrialRow& trial);

/// Of what load_trial_images gives. Needs a current GL context.
TrialPictures upload_trial(const std::vector<LdrImage>& images);

/// Draws them at their places in the back buffer.
void draw_pictures(const TrialPictures& pictures, const Layout& layout);

}  // namespace equilux
