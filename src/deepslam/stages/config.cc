#include "deepslam/stages/config.h"

#include <array>

#include "deepslam/stages/retired_options.h"

namespace deepslam::stages {
namespace {

constexpr std::array<std::string_view, 3> kPoses = {"track", "capture", "prior"};
constexpr std::array<std::string_view, 3> kDetectSources = {"network", "file", "none"};
constexpr std::array<std::string_view, 3> kDetectFrames = {"new", "keyframes", "all"};
constexpr std::array<std::string_view, 2> kAssociationMethods = {kBySurface, "votes"};
constexpr std::array<std::string_view, 2> kAppearances = {"measured", "class"};
constexpr std::array<std::string_view, 3> kSurroundings = {"layout", "measured", "both"};
constexpr std::array<std::string_view, 4> kUsdFiles = {"none", "usdz", "usda", "both"};
const std::set<std::string>& PathOptions() {
  static const std::set<std::string> names = {
      "classes.file", "detect.weights", "detect.file", "propose.library", "propose.priors"};
  return names;
}

void Describe(OptionsVisitor& visitor, TrackStageOptions& options) {
  visitor.Choice("poses",
                 options.poses,
                 kPoses,
                 "estimate camera poses, take those of the capture, or start from them");
}

void Describe(OptionsVisitor& visitor, DetectStageOptions& options) {
  visitor.Choice("source", options.source, kDetectSources, "where boxes come from");
  visitor.Field("weights",
                options.weights,
                "detector: name of a file in the data folder's weights/, or a path (ONNX); empty: "
                "yolo11n-seg there, else yolov8s");
  visitor.Field("file", options.file, "COCO file of boxes and masks, for source file");
  visitor.Choice("frames",
                 options.frames,
                 kDetectFrames,
                 "frames the detector looks at; new: keyframes that show something new, sharper "
                 "ones beside them");
}

void Describe(OptionsVisitor& visitor, ProposeStageOptions& options) {
  visitor.Field("use_depth",
                options.use_depth,
                "sources may look at depth; if not, at colour and silhouettes alone");
  visitor.Field("retrieval", options.retrieval, "offer CAD models of the furniture library");
  visitor.Field("fused", options.fused, "offer the object's own fused measurement");
  visitor.Field("network", options.network, "offer what the shape networks of a class propose");
  visitor.Field("priors",
                options.priors,
                "folder with the shape networks, CLASS/*.onnx; empty: `priors` in the data folder, "
                "else those that came with the program");
  visitor.Field("library",
                options.library,
                "folder of the furniture library; empty: the one in the data folder");
}

void Describe(OptionsVisitor& visitor, FuseStageOptions& options) {
  visitor.Field(
      "leave_objects_out",
      options.leave_objects_out,
      "fuse only frames that the detector looked at, without the pixels of mapped objects");
}

void Describe(OptionsVisitor& visitor, AssociateStageOptions& options) {
  visitor.Choice("method",
                 options.method,
                 kAssociationMethods,
                 "objects out of the surface of all frames, or by votes of the last frames alone, "
                 "as in the paper");
}

void Describe(OptionsVisitor& visitor, ExportStageOptions& options) {
  visitor.Field("uncompressed_twin",
                options.uncompressed_copy,
                "also write scene.uncompressed.glb, without Draco");
  visitor.Choice(
      "appearance",
      options.appearance,
      kAppearances,
      "colours of objects: as the frames saw them, with the class colour to switch to, or "
      "the class colour alone (objects of one model then share a mesh)");
  visitor.Field("labelled_ply",
                options.labelled_ply,
                "also write scene.ply: all meshes in one, vertices labelled by object id");
  visitor.Field("habitat",
                options.habitat,
                "also write scene.semantic.glb and scene.semantic.txt, as Habitat reads them");
  visitor.Field("plan_dxf",
                options.plan_dxf,
                "also write plan.dxf: the floor plan for CAD programs, in metres");
  visitor.Choice("usd",
                 options.usd,
                 kUsdFiles,
                 "also write the scene as Universal Scene Description: scene.usdz, scene.usda, or "
                 "both");
  visitor.Field("usd_physics",
                options.usd_physics,
                "in it also what moves, masses and the convex pieces that collide");
  visitor.Field("simulator",
                options.simulator,
                "also write simulator/: the scene for MuJoCo (MJCF) and others (URDF), with meshes "
                "and the convex pieces that collide");
  visitor.Field("room", options.room, "put the room's measured surface into the scene");
  visitor.Choice(
      "surroundings",
      options.surroundings,
      kSurroundings,
      "what stands around the objects: walls, floors, ceilings and openings as the layout "
      "has them, the room's measured surface, or both (the surface then without what the "
      "layout stands for)");
  visitor.Field("trajectory", options.trajectory, "put camera path and keyframes into the scene");
}

template <typename... Options>
pipeline::OptionSection Section(std::string name, std::string help, Options&... options) {
  return {name, std::move(help), [name, &options...](OptionsVisitor& visitor) {
            (Describe(visitor, options), ...);
            DescribeRetired(name, visitor);
          }};
}

}  // namespace

std::vector<pipeline::OptionSection> Sections(Config& c) {
  return {
      {"classes",
       "Classes of objects",
       [&c](OptionsVisitor& visitor) {
         visitor.Field("file",
                       c.classes_file,
                       "table of classes (YAML); empty: the one of configs/classes.yaml");
       }},
      Section("track", "Camera tracking", c.track_stage, c.track),
      Section("track.covisible", "Keyframes that see the same, measured as well", c.covisible),
      Section("track.join", "Sub-trajectories that tracking could not tie together", c.joining),
      Section("ground", "Ground plane", c.ground),
      Section("layout", "Walls, rooms and openings", c.layout),
      Section("layout.surface",
              "The coarse surface of the whole capture, which they are read from",
              c.coarse),
      Section("detect", "Boxes in colour images", c.detect_stage, c.detect),
      Section("detect.network", "The detector network", c.network),
      Section("detect.clusters",
              "Boxes of floor-standing depth clusters that no detection covers",
              c.clusters),
      Section("segment", "Which pixels of a box are the object", c.segment),
      Section("associate", "Which detections are one object", c.associate_stage, c.associate),
      Section("associate.things", "Things found in the surface of all frames", c.things),
      Section("views", "Views of an object that later stages look at", c.views),
      Section("propose", "Whole shapes for objects", c.propose_stage),
      Section("propose.retrieval", "CAD models of the library", c.retrieval),
      Section("propose.measured", "The object's own fused measurement"),
      Section("propose.networks", "Shape networks", c.shape_network),
      Section("register", "Where a shape stands"),
      Section("select", "Which shape it is", c.select),
      Section("select.refine", "The networks' best shape follows the depth", c.shape_refinement),
      Section("loops", "Places seen again; constellations of objects", c.loops),
      Section("loops.appearance", "Places seen again by what they look like", c.appearance),
      Section("optimize", "Graph of cameras, objects and ground", c.optimize),
      Section("mesh.surface", "Surface of the chosen shapes", c.surface),
      Section("mesh.refine", "Smoothing and decimation", c.refine),
      Section("mesh.colour", "Colours from the frames", c.colour),
      Section("fuse", "The room's measured surface", c.fuse_stage, c.fuse),
      Section("export", "The scene file", c.export_stage),
      Section("export.ground", "The seen piece of floor", c.ground_polygon),
      Section("export.gltf", "glTF and Draco", c.gltf),
      Section("export.convex", "Convex pieces of objects, for physics", c.convex),
  };
}

std::map<std::string, std::string> KeyOptions(Config config,
                                              const std::set<std::string>& sections) {
  std::map<std::string, std::string> values;
  for (const pipeline::OptionSection& section : Sections(config)) {
    if (sections.contains(section.name)) values.merge(pipeline::OptionValues(section));
  }
  for (const std::string& name : PathOptions()) values.erase(name);
  return values;
}

}  // namespace deepslam::stages
