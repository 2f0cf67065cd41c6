// Methods, counts and checks as JSON.
#include "renderer/reference_record.h"

#include "protocols/condition.h"

namespace equilux {
namespace {

void tell_plan(const SetMeasures& sets, Json& json) {
  json.set("clamp", format_clamp(sets.clamp_level)).set("sets", sets.sets).set("vpls", sets.mean_vpls);
  json.set("error_ratio", sets.error_ratio).set("cut_size", sets.mean_clusters);
}

void tell_method(const std::optional<SetMeasures>& sets, double paths, Json& json) {
  json.set("method", sets ? "compensated" : "path");
  json.set("paths", sets ? sets->compensation_paths : paths);
}

Json tell_added(const std::vector<AddedTurn>& added) {
  Json turns{Json::Array{}};
  for (const AddedTurn& turn : added) {
    Json json;
    tell_method(turn.sets, turn.paths, json);
    json.set("share", turn.share);
    if (turn.sets) tell_plan(*turn.sets, json);
    turns.push(std::move(json));
  }
  return turns;
}

void tell_sets(const SetMeasures& sets, Json& json) {
  tell_plan(sets, json);
  Json check{Json::Array{}};
  for (const RegionCheck& region : sets.regions) {
    Json row;
    row.set("region", region.name).set("pixels", static_cast<std::int64_t>(region.light.pixels));
    row.set("mean", region.light.mean).set("standard_error", region.light.standard_error);
    row.set("path_traced", region.traced.mean).set("path_traced_error", region.traced.standard_error);
    row.set("z", region.z());
    check.push(std::move(row));
  }
  json.set("check", std::move(check));
}

}  // namespace

Json tell_reference(const FamilyLayers& layers) {
  Json json;
  double first_paths = layers.paths;
  for (const AddedTurn& turn : layers.added) first_paths -= turn.paths;
  tell_method(layers.sets, first_paths, json);
  json.set("turns", static_cast<std::int64_t>(layers.added.size() + 1));
  if (!layers.added.empty()) json.set("added", tell_added(layers.added));
  if (layers.sets) tell_sets(*layers.sets, json);
  return json;
}

Json tell_room(const FamilyLayers& layers) {
  Json json;
  if (!layers.room) return json;
  json.set("method", "compensated")
      .set("paths", layers.room->compensation_paths)
      .set("turns", layers.room_turns);
  tell_sets(*layers.room, json);
  return json;
}

}  // namespace equilux
