#include "deepslam/modelling/proposal_look.h"

#include <span>
#include <utility>

#include "deepslam/propose/level_box.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/shape_prior.h"
#include "deepslam/scene/object_name.h"

namespace deepslam::modelling {
namespace {

std::optional<LookedShape> Propose(const propose::ShapePrior& prior,
                                   const ObjectView& view,
                                   bool by_depth,
                                   std::string& note) {
  const Result<propose::NetworkCrop> crop = propose::MakeNetworkCrop(view, by_depth);
  if (!crop.ok()) {
    note = crop.error().message;
    return std::nullopt;
  }
  const Result<propose::PriorEncoding> encoding = prior.Encode(*crop);
  if (!encoding.ok()) {
    note = encoding.error().message;
    return std::nullopt;
  }
  Result<VoxelGrid> shape = prior.Decode(encoding->latents, by_depth);
  if (!shape.ok()) {
    note = shape.error().message;
    return std::nullopt;
  }
  return LookedShape{std::move(shape).value(), encoding->azimuth_rad, encoding->elevation_rad};
}

// The middle of what was measured.
Eigen::Vector3d CenterWorld(std::span<const ObjectView> views) {
  const propose::LevelCloud cloud = propose::AccumulateLevel(views);
  if (cloud.points.empty()) return Eigen::Vector3d::Zero();
  const propose::LevelBox box = propose::MeasureBox(cloud.points);
  return cloud.level_from_world.Inverse() *
         Eigen::Vector3d(box.center_m.x(), box.center_m.y(), 0.5 * box.size_m.z());
}

ProposalLook Look(const std::string& object,
                  const propose::ShapePrior& prior,
                  const ObjectView& view) {
  ProposalLook look;
  look.object = object;
  look.frame = view.frame;
  if (Result<propose::NetworkCrop> crop = propose::MakeNetworkCrop(view, true); crop.ok())
    look.crop = std::move(crop).value();
  look.by_depth = Propose(prior, view, true, look.note);
  look.by_colour = Propose(prior, view, false, look.note);
  return look;
}

}  // namespace

Result<std::vector<ProposalLook>> LookAtProposals(const TrackedObjects& objects,
                                                  const propose::ShapePriors& priors,
                                                  const std::map<ObjectId, VoxelGrid>& retrieved,
                                                  const ViewSource& views,
                                                  int max_views) {
  std::vector<ProposalLook> looks;
  const auto look_at = [&](const TrackViews& of_track) {
    const ObjectTrack& track = *of_track.track;
    const auto prior = priors.find(track.class_name);
    if (prior == priors.end() || of_track.views.empty()) return;
    const std::vector<ObjectView>& seen = of_track.views;
    for (const std::size_t n : propose::ChooseViews(seen, CenterWorld(seen), max_views)) {
      looks.push_back(Look(ObjectName(track.class_name, track.id), *prior->second, seen[n]));
      if (const auto model = retrieved.find(track.id); model != retrieved.end())
        looks.back().retrieved = model->second;
    }
  };
  const auto use = [&](std::span<TrackViews> batch) {
    for (const TrackViews& of_track : batch) look_at(of_track);
    return Ok();
  };
  const Status status = views.ForBatches(objects, observe::ViewContent::kColourAndDepth, use);
  if (!status.ok()) return status.error();
  return looks;
}

}  // namespace deepslam::modelling
