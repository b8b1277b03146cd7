#include "deepslam/select/placed.h"

#include <algorithm>

namespace deepslam::select {

int NumRegistered(std::span<const ViewRegistration> views) {
  return static_cast<int>(
      std::count_if(views.begin(), views.end(), [](const auto& view) { return view.ok; }));
}

std::vector<bool> Placed(std::span<const CandidateRegistration> registrations) {
  int most = 0;
  for (const CandidateRegistration& registration : registrations)
    most = std::max(most, NumRegistered(registration.views));
  std::vector<bool> placed;
  for (const CandidateRegistration& registration : registrations)
    placed.push_back(registration.ok && 2 * NumRegistered(registration.views) >= most);
  return placed;
}

}  // namespace deepslam::select
