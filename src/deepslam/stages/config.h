// The whole configuration: the options of every algorithm and of the stages around them.
#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "deepslam/associate/associate.h"
#include "deepslam/convex/decompose.h"
#include "deepslam/detect/cluster_detector.h"
#include "deepslam/detect/detect_frame.h"
#include "deepslam/detect/detector.h"
#include "deepslam/discovery/find_things.h"
#include "deepslam/fuse/choose_frames.h"
#include "deepslam/fuse/coarse_fusion.h"
#include "deepslam/fuse/tsdf.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/graph/object_graph.h"
#include "deepslam/ground/ground_plane.h"
#include "deepslam/layout/estimate_layout.h"
#include "deepslam/loop/appearance.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/loop/covisible.h"
#include "deepslam/mapping/join_sub_trajectories.h"
#include "deepslam/mesh/colour_mesh.h"
#include "deepslam/mesh/extract_surface.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/mesh/refine_mesh.h"
#include "deepslam/observe/object_views.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/refine/refine_options.h"
#include "deepslam/registration/register_shape.h"
#include "deepslam/segment/segment_objects.h"
#include "deepslam/select/select_options.h"
#include "deepslam/tracking/odometry.h"

namespace deepslam::stages {

struct TrackStageOptions {
  std::string poses = "track";  // track | capture | prior
};

struct DetectStageOptions {
  std::string source = "network";  // network | file | none
  std::string weights;             // as FindWeights takes it
  std::string file;                // COCO file of source `file`
  std::string frames = "new";      // new | keyframes | all
};

struct ProposeStageOptions {
  // false: sources see colour and silhouettes alone; the fused measurement, being depth, is none.
  bool use_depth = true;
  bool retrieval = true;
  bool fused = true;
  bool network = true;
  std::string priors;   // folder with CLASS/*.onnx; empty: `priors` in the data folder, else the
                        // program's own
  std::string library;  // folder; empty: `library` in the data folder
};

struct FuseStageOptions {
  bool leave_objects_out = false;
};

inline constexpr std::string_view kBySurface = "surface";
struct AssociateStageOptions {
  std::string method{kBySurface};  // surface | votes
};

struct ExportStageOptions {
  bool uncompressed_copy = true;        // scene.uncompressed.glb, for programs without Draco
  std::string appearance = "measured";  // measured | class
  bool labelled_ply = false;            // scene.ply
  bool habitat = false;                 // scene.semantic.glb and scene.semantic.txt
  std::string usd = "none";             // none | usdz | usda | both
  bool usd_physics = false;             // bodies, masses and collision pieces in it
  bool simulator = false;               // simulator/: MJCF, URDF, meshes and convex pieces
  bool room = true;
  bool plan_dxf = false;              // plan.dxf
  std::string surroundings = "both";  // layout | measured | both
  bool trajectory = true;
};

struct Config {
  std::string classes_file;  // empty: the table compiled in
  TrackStageOptions track_stage;
  tracking::OdometryOptions track;
  ground::GroundOptions ground;
  fuse::CoarseOptions coarse;
  layout::LayoutOptions layout;
  DetectStageOptions detect_stage;
  detect::DetectOptions detect;
  detect::DetectorOptions network;
  detect::ClusterOptions clusters;
  segment::SegmentOptions segment;
  AssociateStageOptions associate_stage;
  associate::AssociateOptions associate;
  discovery::ThingOptions things;
  observe::ViewOptions views;
  ProposeStageOptions propose_stage;
  propose::RetrievalOptions retrieval;
  propose::NetworkOptions shape_network;
  registration::RegisterOptions registration;
  select::SelectOptions select;
  refine::RefineOptions shape_refinement;
  loop::LoopOptions loops;
  loop::AppearanceOptions appearance;
  loop::CovisibleOptions covisible;
  mapping::JoiningOptions joining;
  graph::GraphOptions optimize;
  mesh::SurfaceOptions surface;
  mesh::RefineOptions refine;
  mesh::ColourOptions colour;
  FuseStageOptions fuse_stage;
  fuse::FuseOptions fuse;
  ExportStageOptions export_stage;
  mesh::GroundPolygonOptions ground_polygon;
  gltf::GltfOptions gltf;
  convex::DecomposeOptions convex;
};

// Every section of the configuration, in the order of the pipeline. `config` must outlive the
// result.
[[nodiscard]] std::vector<pipeline::OptionSection> Sections(Config& config);

// Values of the named sections for a stage's key. Options that name files are left out: their
// content is hashed instead.
[[nodiscard]] std::map<std::string, std::string> KeyOptions(Config config,
                                                            const std::set<std::string>& sections);

}  // namespace deepslam::stages
