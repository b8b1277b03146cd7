#include "deepslam/stages/proposal_look.h"

#include <map>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/capture.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/shape_prior.h"
#include "deepslam/stages/load_priors.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;

// The first library model of every object.
Result<std::map<ObjectId, VoxelGrid>> FirstRetrieved(const StageContext& context) {
  const Result<Proposals> proposals = ReadProposals(context);
  if (!proposals.ok()) return proposals.error();
  std::map<ObjectId, VoxelGrid> first;
  for (const ShapeCandidate& candidate : proposals->candidates) {
    if (candidate.library_id.empty() || first.contains(candidate.object)) continue;
    Result<VoxelGrid> model = ReadModel(context, "propose", candidate.model);
    if (!model.ok()) return model.error();
    first.emplace(candidate.object, std::move(model).value());
  }
  return first;
}

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

Result<std::vector<ProposalLook>> LookAtProposals(const std::filesystem::path& workspace,
                                                  const RunInputs& inputs,
                                                  int max_views,
                                                  Progress& progress) {
  const StageContext context(
      workspace, {}, {"track", "ground", "segment", "associate", "propose"}, progress);
  const auto priors = PriorsOf(inputs);
  if (!priors.ok()) return priors.error();
  if (!*priors) return InvalidInput("no shape networks are there; name a folder by propose.priors");
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<std::vector<Segment>> segments = ReadSegments(context, "associate");
  if (!segments.ok()) return segments.error();
  if (const Status status =
          CheckOfThisCapture(trajectory->frames.size(), *segments, *inputs.capture->frames);
      !status.ok())
    return status.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Association> association = ReadAssociation(context, "associate");
  if (!association.ok()) return association.error();
  const Result<std::map<ObjectId, VoxelGrid>> retrieved = FirstRetrieved(context);
  if (!retrieved.ok()) return retrieved.error();
  const Result<ObjectViews> views =
      CollectViews(context, inputs, *trajectory, *ground, *association);
  if (!views.ok()) return views.error();

  std::vector<ProposalLook> looks;
  for (const ObjectTrack& track : association->tracks) {
    const auto prior = (*priors)->find(track.class_name);
    const auto found = views->find(track.id);
    if (prior == (*priors)->end() || found == views->end() || found->second.empty()) continue;
    const std::vector<ObjectView>& of_object = found->second;
    for (const std::size_t n : propose::ChooseViews(of_object, CenterWorld(of_object), max_views)) {
      looks.push_back(Look(fmt::format("{}_{:02d}", track.class_name, track.id.value),
                           *prior->second,
                           of_object[n]));
      if (const auto model = retrieved->find(track.id); model != retrieved->end())
        looks.back().retrieved = model->second;
    }
  }
  return looks;
}

}  // namespace deepslam::stages
