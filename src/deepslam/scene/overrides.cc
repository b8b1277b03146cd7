#include "deepslam/scene/overrides.h"

#include <map>

namespace deepslam {
namespace {

// The new classes of objects.
std::map<ObjectId, std::string> Relabelled(const Overrides& overrides) {
  std::map<ObjectId, std::string> relabelled;
  for (const TextOverride& relabel : overrides.relabel)
    relabelled.emplace(relabel.object, relabel.text);
  return relabelled;
}

}  // namespace

std::vector<NamedObject> NamesOfTracks(const Overrides& overrides) {
  const std::map<ObjectId, std::string> relabelled = Relabelled(overrides);
  std::vector<NamedObject> names;
  const auto is_new_name = [&](const NamedObject& name) {
    const auto found = relabelled.find(name.object);
    return found != relabelled.end() && found->second == name.class_name;
  };
  for (const NamedObject& name : overrides.named) {
    if (!is_new_name(name)) names.push_back(name);
  }
  for (const NamedObject& name : overrides.named_choices) {
    if (relabelled.contains(name.object) && !is_new_name(name)) names.push_back(name);
  }
  return names;
}

std::vector<NamedObject> NamesOfChoices(const Overrides& overrides) {
  const std::map<ObjectId, std::string> relabelled = Relabelled(overrides);
  std::vector<NamedObject> names = overrides.named_choices;
  std::erase_if(names, [&](const NamedObject& name) { return relabelled.contains(name.object); });
  return names;
}

}  // namespace deepslam
