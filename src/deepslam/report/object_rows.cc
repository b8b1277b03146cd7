#include "deepslam/report/object_rows.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "deepslam/geometry/box.h"

namespace deepslam::report {
namespace {

std::vector<CandidateRow> CandidateRows(const MapObject& object, const CandidatesById& by_id) {
  std::vector<CandidateRow> rows;
  for (const CandidateScore& score : object.scores) {
    CandidateRow row;
    if (const auto it = by_id.find(score.candidate); it != by_id.end()) {
      row.model = it->second->model;
      row.source = TraitsOf(it->second->source).in_words;
      row.is_partial = TraitsOf(it->second->source).is_partial;
    }
    row.score = score.score;
    row.surface_share = score.surface_share;
    row.coverage_share = score.coverage_share;
    row.free_violation = score.free_violation;
    row.num_views = score.num_views;
    row.chosen = score.candidate == object.chosen;
    row.note = score.note;
    rows.push_back(std::move(row));
  }
  return rows;
}

Box3 BoundsOf(const TriangleMesh& mesh) {
  Box3 box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.Extend(vertex.cast<double>());
  return box;
}

double LowestPointM(const TriangleMesh& mesh, const Pose3& world_from_object) {
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    lowest_m = std::min(lowest_m, (world_from_object * vertex.cast<double>()).z());
  return mesh.vertices.empty() ? 0.0 : lowest_m;
}

}  // namespace

CandidatesById ById(std::span<const ShapeCandidate> candidates) {
  CandidatesById by_id;
  for (const ShapeCandidate& candidate : candidates) by_id[candidate.id] = &candidate;
  return by_id;
}

ObjectRow MakeObjectRow(const MapObject& object,
                        const TriangleMesh& mesh,
                        Rgb8 colour,
                        const CandidatesById& by_id) {
  ObjectRow row;
  row.name = ObjectName(object);
  row.class_name = object.class_name;
  row.size_m = BoundsOf(mesh).Size();
  row.world_from_object = object.world_from_object;
  row.bottom_above_ground_m = LowestPointM(mesh, object.world_from_object);
  row.confidence = object.confidence;
  row.num_views = static_cast<int>(object.views.size());
  row.source = TraitsOf(object.source).in_words;
  row.credit = object.credit;
  row.note = object.note;
  row.colour = colour;
  row.candidates = CandidateRows(object, by_id);
  return row;
}

}  // namespace deepslam::report
