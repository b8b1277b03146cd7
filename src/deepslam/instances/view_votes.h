// What the frames say about which superpoints are one thing: each detection of a frame claims the
// superpoints that lie in it, and what one detection claims together is one thing there.
//
// View consensus in the manner of MaskClustering (Yan et al. 2024): frames that see two superpoints
// and claim at least one of them vote, for the same thing where one detection claims both, against
// it otherwise. Of nested detections the smallest claims: a chair before a table is inside the
// table's box, the table is not inside the chair's.
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/options.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/instances/superpoints.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/scene/detection.h"

namespace deepslam::instances {

struct VoteOptions {
  double min_visible_share = 0.3;  // of a superpoint's elements, for a frame to see it
  double min_mask_share = 0.6;     // of its visible elements inside an instance mask that claims it
  double min_box_share = 0.85;     // the same of a box that came without a mask
  double depth_noise_m = 0.04;  // an element is visible where the depth is as far off as this ...
  double depth_noise_per_m = 0.02;  // ... plus this times the depth, at most
};
void Describe(OptionsVisitor& visitor, VoteOptions& options);

// One frame of the capture, as the votes are taken from it.
struct VotingView {
  const DepthImage* depth_m = nullptr;  // 0 = invalid
  PinholeCamera camera;
  Pose3 camera_from_level;
  std::span<const Detection> detections;  // of this frame
};

// The elements that the frame measured, with their pixels: u, v of each.
struct VisibleElements {
  std::vector<int> elements;  // ascending
  std::vector<Eigen::Vector2i> pixels;
};
[[nodiscard]] VisibleElements FindVisible(const SurfaceElements& elements,
                                          const VotingView& view,
                                          const VoteOptions& options);

// Which detection claims each superpoint of one frame.
struct FrameClaims {
  std::vector<int> superpoints;  // that the frame sees, ascending
  std::vector<int> claimed_by;   // of each of them: index of the frame's detection; -1: none
};
[[nodiscard]] FrameClaims ClaimSuperpoints(const Superpoints& superpoints,
                                           const VisibleElements& visible,
                                           std::span<const Detection> detections,
                                           const VoteOptions& options);

using SuperpointPair = std::pair<int, int>;  // first below second

struct PairVotes {
  double same = 0;
  double different = 0;
};

struct ViewVotes {
  std::map<SuperpointPair, PairVotes> pairs;  // only those that some frame said something about
  // Of each superpoint: sum of the scores of the detections that claimed it, by their class; what
  // clusters guess by size counts a tenth.
  std::vector<std::map<std::string, double>> classes;
  std::vector<int> num_views;  // of each superpoint: frames that saw it
};

// Adds the claims of one frame. `votes` is of this number of superpoints, or empty before the first
// frame.
void AddVotes(const FrameClaims& claims,
              std::span<const Detection> detections,
              int num_superpoints,
              ViewVotes& votes);

}  // namespace deepslam::instances
