// Rows of the page's object list, out of a map's values.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::report {

using CandidatesById = std::map<CandidateId, const ShapeCandidate*>;

// Points into `candidates`.
[[nodiscard]] CandidatesById ById(std::span<const ShapeCandidate> candidates);

// `mesh`: the object's, metric object frame, empty where it has no surface. Candidates stand in the
// order of the object's scores; those that are not in `by_id` have no model and no source. Without
// pictures.
[[nodiscard]] ObjectRow MakeObjectRow(const MapObject& object,
                                      const TriangleMesh& mesh,
                                      Rgb8 colour,
                                      const CandidatesById& by_id);

}  // namespace deepslam::report
