// What modelling objects takes beside its input: options of the algorithms that it joins, and what
// a person chose.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "deepslam/core/ids.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/modelling/model_source.h"
#include "deepslam/modelling/prepared_models.h"
#include "deepslam/modelling/view_source.h"
#include "deepslam/refine/refine_options.h"
#include "deepslam/registration/register_shape.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/select/select_options.h"

namespace deepslam::modelling {

struct HandChoice {
  std::string file;  // for messages
  // The candidate a person chose for an object among these, which are the object's; invalid where
  // nothing was chosen. Empty: nothing was chosen for any object.
  std::function<Result<CandidateId>(ObjectId, std::span<const ShapeCandidate>)> choose;
};

struct ObjectOptions {
  registration::RegisterOptions registration;
  select::SelectOptions select;
  refine::RefineOptions refinement;
  bool use_depth = true;  // of the views, where networks proposed
  HandChoice choice;
  // The room, along the path of the views: no completed model reaches through its walls, and
  // furniture stands with its back to them. None where it is not known.
  const Layout* layout = nullptr;
  const ClassTable* classes = nullptr;  // none: things of every class have a front
};

// Views and models of the objects, where models are kept that several steps prepare, and who is
// told how far it is.
struct ObjectSources {
  const ViewSource& views;
  const ModelSource& models;
  PreparedModels& prepared;
  Progress& progress;
};

}  // namespace deepslam::modelling
