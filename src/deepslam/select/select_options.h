// Options of scoring and selection.
#pragma once

#include <string>

#include "deepslam/core/options.h"

namespace deepslam::select {

struct SelectOptions {
  std::string mode = "offline";  // offline | greedy
  // Object points per view: the share S is then good to 2 %, one deviation.
  static constexpr int kMaxPoints = 600;
  // Longer side of the crops that models are rendered into: a pixel is about a voxel.
  static constexpr int kMaxRender_px = 80;
  // Distance of a good model from the true surface, beside noise and voxels: a voxel of a table.
  static constexpr double kModelTolerance_m = 0.015;
  // Beyond the tolerance agreement fades to nothing over this length, twice the tolerance, so that
  // no step decides.
  static constexpr double kFade_m = 0.03;
  // Gap between the model's bottom and the ground that is no fault: carpets, small castors, and two
  // centimetres that depth of a floor leaves open.
  static constexpr double kGroundTolerance_m = 0.03;
  // Depth further than this from a whole model may be of something else that was cut out with it:
  // as far as registration looks (register_shape.h).
  static constexpr double kReach_m = 0.15;
  // The margin of a fused candidate over the whole models: it is made of the depth it is
  // scored by, noise included. Depth out of a whole model's reach does not count against it here.
  static constexpr double kFusedMargin = 0.05;
  // ... and by this more, when it was seen from one side: it holds nothing of the sides nobody saw.
  // In proportion to the directions nobody saw well: nothing is left of it where the cameras went
  // all round.
  static constexpr double kOneSidedMargin = 0.2;
  // The margin of a product of the library over the networks' shapes where nobody saw the other
  // sides, in proportion to the directions that nobody saw well: among many products one fits what
  // was seen by chance. Of 63 things seen from within 60 degrees, with 0, 0.02 and 0.05 the winner
  // has IoU 0.381, 0.387 and 0.380, and 85.9, 86.5 and 86.0 % of the unseen surface within 5 cm.
  static constexpr double kCatalogueMargin = 0.02;
  // A margin of this much over the whole models is enough, whatever depth it comes from.
  static constexpr double kSufficientMargin = 0.25;
  // The margin of a refined shape over the others: it has seen the depth it is scored by.
  static constexpr double kRefinedMargin = 0.01;
  // The same of a completed model. Below zero, since near equality says that the score has reached
  // its top: in seven objects a completed shape scored within 0.02 below its model, and was the
  // better one by truth or held-out depth each time.
  static constexpr double kCompletedMargin = -0.01;
  // Subtracted from the score of a candidate that turns its back to all cameras: where depth cannot
  // tell front from back, furniture faces where people go.
  static constexpr double kBackPenalty = 0.03;
  // Subtracted from the score of a candidate whose front is turned to a wall that it stands at, and
  // in part of one that stands at it with a side, or that reaches far through a wall (WallConflict
  // of scene/sides_at_walls.h): of candidates that depth hardly tells apart, scores differ by less.
  static constexpr double kBlockedPenalty = 0.05;
  // Things whose longest side is smaller are left out of the map.
  double min_size_m = 0.25;
  // What no detection names is left out of the map where its confidence is below this.
  double min_unnamed_confidence = 0.25;
  // Score at which an object is as likely right as wrong, in the rule that lowers the confidence
  // of objects with a low score.
  static constexpr double kGoodScore = 0.6;
  // Views from which on their number no longer limits the confidence.
  static constexpr double kFullConfidenceViews = 4;
};
void Describe(OptionsVisitor& visitor, SelectOptions& options);

}  // namespace deepslam::select
