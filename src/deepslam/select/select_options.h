// Options of scoring and selection.
#pragma once

#include <string>

#include "deepslam/core/options.h"

namespace deepslam::select {

struct SelectOptions {
  std::string mode = "offline";  // offline | greedy
  int max_points = 600;          // object points per view
  int max_render_px = 80;        // longer side of the rendered crops
  double model_tolerance_m =
      0.015;  // how far a good model may be from the true surface, beside noise and voxels
  double fade_m = 0.03;  // beyond the tolerance agreement fades to nothing over this length
  double ground_tolerance_m =
      0.05;  // gap between the model's bottom and the ground that is no fault
  // Depth further than this from a whole model may be of something else that was cut out with it.
  double reach_m = 0.15;
  // By how much a fused candidate has to lead the whole models: it is made of the depth it is
  // judged by, noise included. Depth out of a whole model's reach does not count against it here.
  double fused_lead = 0.05;
  // ... and by this more, when it was seen from one side: it holds nothing of the sides nobody saw.
  // In proportion to the directions nobody saw well: nothing is left of it where the cameras went
  // all round.
  double fused_handicap = 0.2;
  // A lead of this much over the whole models is enough, whatever depth it comes from.
  double fused_margin = 0.25;
  // By how much a refined shape has to lead the others: it has seen the depth it is judged by.
  double refined_lead = 0.01;
  // The same of a completed model. Below zero, since near equality says that the score has reached
  // its top, not that the details are wrong (docs/evaluation.md, "Completed models").
  double completed_lead = -0.01;
  // Subtracted from the score of a candidate that turns its back to all cameras: where depth cannot
  // tell front from back, furniture faces where people go.
  double back_handicap = 0.03;
  // Things whose longest side is smaller are left out of the map.
  double min_size_m = 0.25;
  // What no detection names is left out of the map where its confidence is below this.
  double min_unnamed_confidence = 0.1;
  double good_score = 0.6;           // score at which an object is as likely right as wrong
  double full_confidence_views = 4;  // views at which their number no longer limits the confidence
};
void Describe(OptionsVisitor& visitor, SelectOptions& options);

}  // namespace deepslam::select
