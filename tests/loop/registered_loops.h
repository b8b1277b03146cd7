// Features along a path, and registrations of proposals: as proposed, and each way of not bearing
// them out.
#pragma once

#include <vector>

#include <gtest/gtest.h>

#include "deepslam/loop/appearance.h"
#include "loop/textured_room.h"

namespace deepslam::loop::testing_support {

inline constexpr int kFeatures = 500;

inline std::vector<KeyframeFeatures> FeaturesAlong(const TexturedRoom& room,
                                                   const std::vector<Pose3>& poses) {
  std::vector<KeyframeFeatures> features;
  for (const Pose3& pose : poses) {
    const auto idx = static_cast<int>(features.size());
    features.push_back(ExtractFeatures(Photograph(room, pose, idx), kCamera, kFeatures));
  }
  return features;
}

inline std::vector<KeyframeRegistration> AsProposed(const std::vector<AppearanceLoop>& proposed) {
  std::vector<KeyframeRegistration> registrations;
  for (const AppearanceLoop& loop : proposed)
    registrations.push_back({true, loop.old_from_new, 1e6 * Matrix6d::Identity(), 0.95, 0.9});
  return registrations;
}

// `num_edges`: how many edges these registrations give.
template <typename NumEdges>
void ExpectRegistrationToBearOut(const std::vector<AppearanceLoop>& loops,
                                 const NumEdges& num_edges) {
  const auto changed = [&](const auto& change) {
    std::vector<KeyframeRegistration> registrations = AsProposed(loops);
    for (KeyframeRegistration& registration : registrations) change(registration);
    return num_edges(registrations);
  };
  EXPECT_EQ(changed([](KeyframeRegistration&) {}), loops.size());
  EXPECT_EQ(changed([](KeyframeRegistration& r) { r.ok = false; }), 0u);
  EXPECT_EQ(changed([](KeyframeRegistration& r) { r.agreement = 0.5; }), 0u);
  EXPECT_EQ(changed([](KeyframeRegistration& r) { r.intensity_correlation = 0.3; }), 0u);
  EXPECT_EQ(changed([](KeyframeRegistration& r) { r.old_from_new.translation_m.x() += 0.4; }), 0u);
}

}  // namespace deepslam::loop::testing_support
