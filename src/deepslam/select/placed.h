// Which candidates stand where their object does.
#pragma once

#include <span>
#include <vector>

#include "deepslam/scene/registration.h"

namespace deepslam::select {

[[nodiscard]] int NumRegistered(std::span<const ViewRegistration> views);

// For each candidate whether it is registered in at least half as many views as the one that is in
// most. Views that pull a model out of its joint pose say that it stands at a place of chance,
// however well that happens to score.
[[nodiscard]] std::vector<bool> Placed(std::span<const CandidateRegistration> registrations);

}  // namespace deepslam::select
