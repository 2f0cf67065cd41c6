// Digests of layers, and the numbers of the curve.
#include "stimuli/origin.h"

#include <fmt/format.h>

#include "base/digest.h"

namespace equilux {
namespace {

std::string find_digest(const LayerRecords& layers, const std::string& name) {
  const auto found = layers.find(name);
  return found == layers.end() ? "none" : found->second.digest;
}

std::string tell_family(const LayerRecords& layers, const ToneRecord& tone, const Family& family) {
  std::string text;
  for (const char* content : kFamilyContents) text += find_digest(layers, layer_name(family, content)) + " ";
  text += fmt::format("{} {} {} {} {}", tone.log_average, tone.white, tone.delta, tone.key, tone.exposure);
  if (tone.tone_operator == "local") text += fmt::format(" local {}", kLocalToneVersion);
  return text;
}

std::string tell_vpls(const LayerRecords& layers, Condition condition) {
  std::string text = find_digest(layers, vpl_layer_name(condition));
  if (condition.cell.normalised) {
    condition.cell.clamp_level = 0;
    text += " normalised to " + find_digest(layers, vpl_layer_name(condition));
  }
  return text;
}

}  // namespace

std::string digest_reference(const LayerRecords& layers, const ToneRecord& tone, const Family& family) {
  return digest_text(tell_family(layers, tone, family));
}

std::string digest_picture(const LayerRecords& layers, const ToneRecord& tone, const Condition& condition) {
  return digest_text(tell_family(layers, tone, family_of(condition)) + " " + tell_vpls(layers, condition));
}

Json tell_picture_reference(const LayerRecords& layers, const Family& family) {
  Json reference = layers.at(layer_name(family, "indirect")).reference;
  const Json& room = layers.at(layer_name(family, "background")).reference;
  if (!reference.is_null() && !room.is_null()) reference.set("room", room);
  return reference;
}

Json tell_picture_vpls(const LayerRecords& layers, const Condition& condition) {
  const std::string name = vpl_layer_name(condition);
  const LayerRecord& layer = layers.at(name);
  if (layer.vpls.is_null()) return {};
  Json json;
  json.set("layer", name).set("count", layer.vpl_count);
  for (const auto& [member, value] : layer.vpls.as_object()) json.set(member, value);
  return json;
}

}  // namespace equilux
