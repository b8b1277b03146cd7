// The seam between sources of whole shapes and everything behind them.
//
// A source looks at all views of one object and offers candidates; register and select score them
// without knowing where they came from. Sources: CAD retrieval, the object's own fused measurement,
// and class-specific networks (one candidate per view, latents filled, and one at the mean latent).
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "deepslam/core/ids.h"
#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/model_library.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::propose {

class ShapePrior;   // shape_prior.h
struct LevelCloud;  // level_cloud.h

// Everything known of one object: its views in ascending frames, with tracked poses.
struct ObjectObservations {
  ObjectId id;
  std::string class_name;
  std::span<const ObjectView> views;
  // AccumulateLevel of the views, where it was made already: sources that look at depth share it.
  const LevelCloud* cloud = nullptr;
  // A detector or a person gave it its class. Of what was named by its size alone models have to be
  // of that size.
  bool is_named = true;
  // The room, along the path of the views: furniture stands with its back to its walls. None where
  // it is not known.
  const Layout* layout = nullptr;
};

class Proposer {
 public:
  virtual ~Proposer() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  // Candidates best first, with invalid ids (the caller numbers them), and their models by key. An
  // object for which the source has nothing gives no candidate and a note that says why.
  // Thread-safe. An Error is a failure of the source itself, not of the object.
  [[nodiscard]] virtual Result<Proposals> Propose(const ObjectObservations& object) const = 0;
};

// What a source may look at. Poses, ground and segmentation are known in either case.
enum class InputChannels {
  kColourAndDepth,
  kColour,  // the colour image and the object's silhouette in it, no depth values
};

struct RetrievalOptions {
  int max_models = 8;  // designs offered per object
  // Views that take part, best supported and spread first: each further one costs a rendering per
  // design.
  static constexpr int kMaxViews = 6;
  // A design may be stretched to the measured size by these factors per axis, relative to its
  // catalogue size: furniture of one kind differs so.
  static constexpr double kStretchMin = 0.7;
  // The reciprocal of kStretchMin.
  static constexpr double kStretchMax = 1.4;
  // Candidates' size range, measured size +- this share: what one-sided views leave open.
  static constexpr double kSizeMargin = 0.25;
};
void Describe(OptionsVisitor& visitor, RetrievalOptions& options);

// The library is shared by all objects and outlives the call that made it. By colour and depth
// designs are ranked by how well they agree with all depth, by colour alone by how well their
// outlines agree with the silhouettes.
[[nodiscard]] std::unique_ptr<Proposer> MakeRetrievalProposer(
    std::shared_ptr<const ModelLibrary> library,
    const ClassTable& classes,
    const RetrievalOptions& options,
    InputChannels channels = InputChannels::kColourAndDepth);

[[nodiscard]] std::unique_ptr<Proposer> MakeFusedProposer(const ClassTable& classes);

struct NetworkOptions {
  // Views whose own shape is offered, the surest of those that are read. Each costs a registration.
  int max_views = 2;
  // Views that are read, or max_views if that is more, best supported and spread first: the shape
  // of all together gains by each.
  static constexpr int kReadViews = 8;
  bool mean_latent = true;      // and what their latents say together (joined_encoding.h)
  bool fit_proportions = true;  // and that in the proportions that all depth has
  // Candidates' size range, measured size +- this share: wider than of designs, since a network's
  // proportions are its own.
  static constexpr double kSizeMargin = 0.3;
};
void Describe(OptionsVisitor& visitor, NetworkOptions& options);

// By class of the map. An object of a class without a prior gets no candidate, and a note.
using ShapePriors = std::map<std::string, std::shared_ptr<const ShapePrior>, std::less<>>;

// By colour alone the depth planes of the crops stay empty, and sizes are the class's.
[[nodiscard]] std::unique_ptr<Proposer> MakeNetworkProposer(
    ShapePriors priors,
    const ClassTable& classes,
    const NetworkOptions& options,
    InputChannels channels = InputChannels::kColourAndDepth);

}  // namespace deepslam::propose
