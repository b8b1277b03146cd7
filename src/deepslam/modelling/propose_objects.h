// Whole shapes for every tracked object, from every source of candidates.
#pragma once

#include <memory>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/modelling/view_source.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::modelling {

struct CandidateSources {
  std::vector<std::unique_ptr<propose::Proposer>> proposers;
  bool use_depth = true;           // false: they see colour and silhouettes alone
  const Layout* layout = nullptr;  // the room, along the path of the views, where it is known
};

// The candidates of one object after the other, of each in the order of the sources, numbered from
// 0 on, with their models. An object without views has none, and a note. The error of a source
// names it.
[[nodiscard]] Result<Proposals> ProposeObjects(const TrackedObjects& objects,
                                               const CandidateSources& sources,
                                               const ViewSource& views,
                                               Progress& progress);

}  // namespace deepslam::modelling
