#include "deepslam/overrides/choices.h"

#include <string>

#include <fmt/format.h>

#include "deepslam/overrides/known_objects.h"

namespace deepslam::overrides {

Status CheckChoices(const Overrides& overrides, std::span<const ObjectTrack> tracks) {
  for (const TextOverride& choice : overrides.choose) {
    if (Find(tracks, choice.object) != nullptr) continue;
    return UnknownObject(overrides,
                         choice.line,
                         fmt::format("{} to choose a candidate for", choice.object.value),
                         tracks);
  }
  return CheckNames(overrides, NamesOfChoices(overrides), tracks);
}

Result<CandidateId> ChosenByHand(const Overrides& overrides,
                                 ObjectId object,
                                 std::span<const ShapeCandidate> candidates) {
  for (const TextOverride& choice : overrides.choose) {
    if (choice.object != object) continue;
    for (const ShapeCandidate& candidate : candidates) {
      if (candidate.model == choice.text || std::to_string(candidate.id.value) == choice.text)
        return candidate.id;
    }
    return InvalidConfig(fmt::format("{}: object {} has no candidate \"{}\"; known are {}",
                                     Place(overrides, choice.line),
                                     object.value,
                                     choice.text,
                                     Known(candidates, [](const ShapeCandidate& candidate) {
                                       return fmt::format(
                                           "{} ({})", candidate.id.value, candidate.model);
                                     })));
  }
  return CandidateId{};
}

}  // namespace deepslam::overrides
