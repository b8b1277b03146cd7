#include "deepslam/stages/retired_options.h"

#include <fmt/format.h>

#include "deepslam/stages/config.h"

namespace deepslam::stages {
namespace {

void DescribeTraits(std::string_view section, OptionsVisitor& visitor) {
  const auto trait = [&](std::string_view of, std::string_view name, std::string_view trait_set) {
    if (of != section) return;
    visitor.Retired(name,
                    fmt::format("`{}` in the table of classes says it (classes.file, `deepslam "
                                "config classes`)",
                                trait_set));
  };
  trait("segment", "level_top_classes", "support_plane: true");
  trait("propose.measured", "solid_classes", "solid_inside: true");
  trait("loops", "yaw_free_classes", "yaw_free: true");
}

}  // namespace

void DescribeRetired(std::string_view section, OptionsVisitor& visitor) {
  DescribeTraits(section, visitor);
  if (section == "select") visitor.Retired("min_size", "it is called select.min_size_m");
  const auto fixed = [&](std::string_view of, std::string_view name, const auto& value) {
    if (of != section) return;
    visitor.Retired(name, fmt::format("its value is fixed at {}; remove it", value));
  };
  fixed("track", "max_normal_angle_deg", alignment::AlignmentOptions::kMaxNormalAngle_deg);
  fixed("track", "correlation_length_px", alignment::AlignmentOptions().correlation_length_px);
  fixed("track",
        "photometric_correlation_length_px",
        alignment::AlignmentOptions().photometric_correlation_length_px);
  fixed("track", "degenerate_ratio", alignment::AlignmentOptions::kDegenerateRatio);
  fixed("track", "min_valid_share", tracking::OdometryOptions::kMinValidShare);
  fixed("track.covisible", "max_turn_deg", loop::CovisibleOptions::kMaxTurn_deg);
  fixed("track.covisible", "min_agreement", loop::CovisibleOptions::kMinAgreement);
  fixed("track.covisible", "min_correlation", loop::CovisibleOptions::kMinCorrelation);
  fixed("track.covisible", "max_move_deg", loop::CovisibleOptions::kMaxMove_deg);
  fixed("track.covisible", "max_residual_m", loop::CovisibleOptions::kMaxResidual_m);
  fixed("track.covisible", "max_residual_deg", loop::CovisibleOptions::kMaxResidual_deg);
  fixed("track.covisible", "max_distance_m", loop::CovisibleOptions::kMaxDistance_m);
  fixed("track.covisible", "max_move_m", loop::CovisibleOptions::kMaxMove_m);
  fixed("track.covisible", "max_gap_keyframes", loop::CovisibleOptions().max_gap_keyframes);
  fixed("ground", "max_pitch_down_deg", ground::GroundOptions::kMaxPitchDown_deg);
  fixed("ground", "max_pitch_up_deg", ground::GroundOptions::kMaxPitchUp_deg);
  fixed("ground", "max_roll_deg", ground::GroundOptions::kMaxRoll_deg);
  fixed("ground", "min_inlier_share", ground::GroundOptions::kMinInlierShare);
  fixed("ground", "min_area_m2", ground::GroundOptions::kMinArea_m2);
  fixed("ground", "level_separation_m", ground::GroundOptions::kLevelSeparation_m);
  fixed("ground", "num_ransac_draws", ground::GroundOptions::kNumRansacDraws);
  fixed("ground", "correlation_length_px", ground::GroundOptions::kCorrelationLength_px);
  fixed("ground", "floor_angle_deg", ground::GroundOptions::kFloorAngle_deg);
  fixed("ground", "floor_distance_m", ground::GroundOptions::kFloorDistance_m);
  fixed("layout", "max_plane_distance_m", layout::PlaneOptions().max_distance_m);
  fixed("layout", "max_plane_angle_deg", layout::PlaneOptions().max_angle_deg);
  fixed("layout", "max_tilt_deg", layout::LineOptions().max_tilt_deg);
  fixed("layout", "min_wall_top_m", layout::LayoutOptions::kMinWallTop_m);
  fixed("layout", "min_room_seen", layout::LayoutOptions::kMinRoomSeen);
  fixed("layout.surface", "space_range_m", fuse::CoarseOptions::kSpaceRange_m);
  fixed("layout.surface", "truncation_m", fuse::CoarseOptions::kTruncation_m);
  fixed("layout.surface", "max_depth_m", fuse::CoarseOptions::kMaxDepth_m);
  fixed("layout.surface", "min_component_faces", fuse::CoarseOptions::kMinComponentFaces);
  fixed("layout.surface", "move_m", fuse::CoarseFrameChoice().move_m);
  fixed("layout.surface", "turn_deg", fuse::CoarseFrameChoice().turn_deg);
  fixed("layout.surface", "frame_step", fuse::CoarseFrameChoice().frame_step);
  fixed("detect", "duplicate_iou", detect::DetectOptions::kDuplicateIou);
  fixed("detect", "same_class_iou", detect::DetectOptions::kSameClassIou);
  fixed("detect", "min_side_px", detect::DetectOptions::kMinSide_px);
  fixed("detect.network", "max_overlap_iou", detect::DetectorOptions::kMaxOverlapIou);
  fixed("detect.network", "max_detections", detect::DetectorOptions::kMaxDetections);
  fixed("detect.clusters", "max_base_m", detect::ClusterOptions::kMaxBase_m);
  fixed("detect.clusters", "cell_m", detect::ClusterOptions::kCell_m);
  fixed("detect.clusters", "min_footprint_m2", detect::ClusterOptions::kMinFootprint_m2);
  fixed("detect.clusters", "min_points_share", detect::ClusterOptions::kMinPointsShare);
  fixed("detect.clusters", "max_covered_share", detect::ClusterOptions::kMaxCoveredShare);
  fixed("detect.clusters", "free_margin_m", detect::ClusterOptions::kFreeMargin_m);
  fixed("detect.clusters", "min_free_share", detect::ClusterOptions::kMinFreeShare);
  fixed("detect.clusters", "min_height_m", detect::ClusterOptions::kMinHeight_m);
  fixed("detect.clusters", "max_height_m", detect::ClusterOptions::kMaxHeight_m);
  fixed("detect.clusters", "max_depth_m", detect::ClusterOptions::kMaxDepth_m);
  fixed("detect.clusters", "min_size_m", detect::ClusterOptions::kMinSize_m);
  fixed("detect.clusters", "max_size_m", detect::ClusterOptions::kMaxSize_m);
  fixed("segment", "height_per_m2", segment::SegmentOptions::kHeight_per_m2);
  fixed("segment", "jump_per_m2", segment::SegmentOptions::kJump_per_m2);
  fixed("segment", "join_m", segment::SegmentOptions::kJoin_m);
  fixed("segment", "border_margin_px", segment::SegmentOptions::kBorderMargin_px);
  fixed("segment", "min_support", segment::SegmentOptions::kMinBoxShare);
  fixed("segment", "min_height_m", segment::SegmentOptions::kMinHeight_m);
  fixed("segment", "jump_m", segment::SegmentOptions::kJump_m);
  fixed("segment", "fill_gap_m", segment::SegmentOptions::kFillGap_m);
  fixed("segment", "min_piece_share", segment::SegmentOptions().min_piece_share);
  fixed("segment", "mask_dilation_px", segment::SegmentOptions().mask_dilation_px);
  fixed("segment", "min_points", segment::SegmentOptions().min_points);
  fixed("associate", "num_vote_frames", associate::AssociateOptions::kNumVoteFrames);
  fixed("associate", "max_dissimilarity_m", associate::AssociateOptions::kMaxDissimilarity_m);
  fixed("associate", "truncation_m", associate::AssociateOptions::kMaxCounted_m);
  fixed("associate", "min_inside_share", associate::AssociateOptions::kMinInsideShare);
  fixed("associate", "min_consensus", associate::AssociateOptions::kMinConsensus);
  fixed("associate", "max_points", associate::AssociateOptions::kMaxSegmentPoints);
  fixed("associate", "min_single_score", associate::AssociateOptions::kMinSingleScore);
  fixed("associate", "min_seen_share", associate::AssociateOptions::kMinDetectedShare);
  fixed("associate", "merge_overlap", associate::AssociateOptions::kMergeOverlap);
  fixed("associate", "voxel_m", associate::AssociateOptions::kVoxel_m);
  fixed("views", "crop_margin", observe::ViewOptions::kCropMargin);
  fixed("views", "border_penalty", observe::ViewOptions::kBorderPenalty);
  fixed("views", "spread_deg", observe::ViewOptions().spread_deg);
  fixed("propose.retrieval", "stretch_min", propose::RetrievalOptions::kStretchMin);
  fixed("propose.retrieval", "stretch_max", propose::RetrievalOptions::kStretchMax);
  fixed("propose.retrieval", "max_views", propose::RetrievalOptions::kMaxViews);
  fixed("propose.retrieval", "size_margin", propose::RetrievalOptions::kSizeMargin);
  fixed("propose.measured", "max_views", 24);
  fixed("propose.measured", "size_margin", 0.25);
  fixed("propose.networks", "size_margin", propose::NetworkOptions::kSizeMargin);
  fixed("register", "max_points", registration::RegisterOptions::kMaxPoints);
  fixed("register", "max_crop_px", registration::RegisterOptions::kMaxCrop_px);
  fixed("register", "num_azimuths", registration::RegisterOptions::kNumAzimuths);
  fixed("register", "num_seed_views", registration::RegisterOptions::kNumSeedViews);
  fixed("register", "num_refined_hypotheses", registration::RegisterOptions::kNumRefinedHypotheses);
  fixed("register", "coarse_radius", registration::RegisterOptions::kCoarseRadius_m);
  fixed("register", "fine_radius", registration::RegisterOptions::kFineRadius_m);
  fixed("register", "upright_sigma", registration::RegisterOptions::kUprightSigma_deg);
  fixed("register", "ground_sigma", registration::RegisterOptions::kGroundSigma_m);
  fixed("register", "size_sigma", registration::RegisterOptions::kSizeSigma);
  fixed("register", "max_move", registration::RegisterOptions().max_move_m);
  fixed("register", "max_turn", registration::RegisterOptions::kMaxTurn_deg);
  fixed("register", "min_inlier_share", registration::RegisterOptions::kMinInlierShare);
  fixed("register", "yaw_free_sigma", registration::RegisterOptions::kYawFreeSigma_deg);
  fixed("register", "symmetry_share", registration::RegisterOptions::kSymmetryShare);
  fixed("register", "min_points", registration::RegisterOptions::kMinPoints);
  fixed("register", "patch", registration::RegisterOptions::kPatch_m);
  fixed("select", "max_points", select::SelectOptions::kMaxPoints);
  fixed("select", "max_render_px", select::SelectOptions::kMaxRender_px);
  fixed("select", "model_tolerance", select::SelectOptions::kModelTolerance_m);
  fixed("select", "ground_tolerance", select::SelectOptions::kGroundTolerance_m);
  fixed("select", "good_score", select::SelectOptions::kGoodScore);
  fixed("select", "full_confidence_views", select::SelectOptions::kFullConfidenceViews);
  fixed("select", "fade", select::SelectOptions::kFade_m);
  fixed("select", "reach", select::SelectOptions::kReach_m);
  fixed("select", "fused_lead", select::SelectOptions::kFusedMargin);
  fixed("select", "fused_handicap", select::SelectOptions::kOneSidedMargin);
  fixed("select", "fused_margin", select::SelectOptions::kSufficientMargin);
  fixed("select", "refined_lead", select::SelectOptions::kRefinedMargin);
  fixed("select", "completed_lead", select::SelectOptions::kCompletedMargin);
  fixed("select", "back_handicap", select::SelectOptions::kBackPenalty);
  fixed("select.refine", "surface_voxels", refine::RefineOptions::kSurfaceVoxels);
  fixed("select.refine", "max_views", refine::RefineOptions::kMaxViews);
  fixed("select.refine", "reach", refine::RefineOptions().reach_m);
  fixed("select.refine", "max_evaluations", refine::RefineOptions().max_evaluations);
  fixed("select.refine", "min_voxels", refine::RefineOptions().min_voxels);
  fixed("select.refine", "prior_weight", refine::RefineOptions().prior_weight);
  fixed("loops", "min_pairs", loop::LoopOptions::kMinPairs);
  fixed("loops", "position_tolerance_m", loop::LoopOptions::kPositionTolerance_m);
  fixed("loops", "local_drift", loop::LoopOptions::kLocalDrift);
  fixed("loops", "yaw_tolerance_deg", loop::LoopOptions::kYawTolerance_deg);
  fixed("loops", "drift_base_deg", loop::LoopOptions::kDriftBase_deg);
  fixed("loops", "drift_deg_per_m", loop::LoopOptions::kDrift_deg_per_m);
  fixed("loops", "max_spread_m", loop::LoopOptions::kMaxSpread_m);
  fixed("loops", "overlap_share", loop::LoopOptions::kOverlapShare);
  fixed("loops", "verify_distance_m", loop::LoopOptions::kVerifyDistance_m);
  fixed("loops", "min_room_agreement", loop::LoopOptions::kMinRoomAgreement);
  fixed("loops", "room_radius_m", loop::LoopOptions::kRoomRadius_m);
  fixed("loops", "ambiguity_ratio", loop::LoopOptions::kAmbiguityRatio);
  fixed("loops", "edge_floor_m", loop::LoopOptions::kEdgeFloor_m);
  fixed("loops", "edge_floor_deg", loop::LoopOptions::kEdgeFloor_deg);
  fixed("loops", "drift_share", loop::LoopOptions::kDriftShare);
  fixed("loops", "add_edges", true);
  fixed("loops", "min_single_overlap", loop::LoopOptions().min_single_overlap);
  fixed("loops", "max_seeds", loop::LoopOptions().max_seeds);
  fixed("loops", "min_object_agreement", loop::LoopOptions().min_object_agreement);
  fixed("loops", "min_room_points", loop::LoopOptions().min_room_points);
  fixed("loops.appearance", "max_features", loop::AppearanceOptions::kMaxFeatures);
  fixed("loops.appearance", "max_candidates", loop::AppearanceOptions::kMaxCandidates);
  fixed("loops.appearance", "min_similarity", loop::AppearanceOptions::kMinSimilarity);
  fixed("loops.appearance", "min_spread_deg", loop::AppearanceOptions::kMinSpread_deg);
  fixed("loops.appearance", "ambiguity_ratio", loop::AppearanceOptions::kAmbiguityRatio);
  fixed("loops.appearance", "min_support", loop::AppearanceOptions::kMinSupport);
  fixed("loops.appearance", "drift_base_deg", loop::AppearanceOptions::kDriftBase_deg);
  fixed("loops.appearance", "drift_deg_per_m", loop::AppearanceOptions::kDrift_deg_per_m);
  fixed("loops.appearance", "max_registrations", loop::AppearanceOptions::kMaxRegistrations);
  fixed("loops.appearance", "min_agreement", loop::AppearanceOptions::kMinAgreement);
  fixed("loops.appearance", "min_correlation", loop::AppearanceOptions::kMinCorrelation);
  fixed("loops.appearance", "max_turn_deg", loop::AppearanceOptions::kMaxTurn_deg);
  fixed("loops.appearance", "variance_scale", loop::AppearanceOptions::kVarianceScale);
  fixed("loops.appearance", "edge_floor_m", loop::AppearanceOptions::kEdgeFloor_m);
  fixed("loops.appearance", "edge_floor_deg", loop::AppearanceOptions::kEdgeFloor_deg);
  fixed("loops.appearance", "max_move_m", loop::AppearanceOptions::kMaxMove_m);
  fixed("loops.appearance", "min_inliers", loop::AppearanceOptions().min_inliers);
  fixed("loops.appearance", "drift_share", loop::AppearanceOptions().drift_share);
  fixed("optimize", "lambda_odometry", graph::GraphOptions::kLambdaOdometry);
  fixed("optimize", "lambda_upright", graph::GraphOptions::kLambdaUpright);
  fixed("optimize", "odometry_variance_scale", graph::GraphOptions::kOdometryVarianceScale);
  fixed("optimize", "odometry_floor_m", graph::GraphOptions::kOdometryFloor_m);
  fixed("optimize", "odometry_floor_deg", graph::GraphOptions::kOdometryFloor_deg);
  fixed("optimize", "object_variance_scale", graph::GraphOptions::kObjectVarianceScale);
  fixed("optimize", "object_floor_m", graph::GraphOptions::kObjectFloor_m);
  fixed("optimize", "object_floor_deg", graph::GraphOptions::kObjectFloor_deg);
  fixed("optimize", "ground_variance_scale", graph::GraphOptions::kGroundVarianceScale);
  fixed("optimize", "ground_floor_m", graph::GraphOptions::kGroundFloor_m);
  fixed("optimize", "ground_floor_deg", graph::GraphOptions::kGroundFloor_deg);
  fixed("optimize", "wall_floor_m", graph::GraphOptions::kWallFloor_m);
  fixed("optimize", "wall_floor_deg", graph::GraphOptions::kWallFloor_deg);
  fixed("optimize", "loss_width", graph::GraphOptions::kLossWidth);
  fixed("optimize", "stand_max_gap_m", graph::GraphOptions::kStandMaxGap_m);
  fixed("optimize", "stand_floor_m", 0);
  fixed("optimize", "lambda_ground", graph::GraphOptions::kLambdaGround);
  fixed("optimize", "use_ground", true);
  fixed("optimize", "odometry_loss", graph::GraphOptions().odometry_loss);
  fixed("optimize", "max_iterations", graph::GraphOptions().max_iterations);
  fixed("mesh.surface", "max_shift_voxels", mesh::SurfaceOptions::kMaxShiftVoxels);
  fixed("mesh.surface", "min_component_share", mesh::SurfaceOptions().min_component_share);
  fixed("mesh.refine", "smoothing_iterations", mesh::RefineOptions::kSmoothingIterations);
  fixed("mesh.refine", "max_error", mesh::RefineOptions().max_error);
  fixed("mesh.colour", "depth_tolerance_m", mesh::ColourOptions::kDepthTolerance_m);
  fixed("mesh.colour", "max_view_angle_deg", mesh::ColourOptions::kMaxViewAngle_deg);
  fixed("mesh.colour", "max_edge_step_m", mesh::ColourOptions::kMaxEdgeStep_m);
  fixed("fuse", "min_component_faces", fuse::FuseOptions().min_component_faces);
  fixed("fuse", "move_m", fuse::FrameChoice().move_m);
  fixed("fuse", "turn_deg", fuse::FrameChoice().turn_deg);
  fixed("fuse", "frame_step", fuse::FrameChoice().frame_step);
  fixed("export.ground", "cell_m", mesh::GroundPolygonOptions::kCell_m);
  fixed("export.ground", "alpha_m", mesh::GroundPolygonOptions::kAlpha_m);
  fixed("export.ground", "simplify_m", mesh::GroundPolygonOptions::kSimplify_m);
  fixed("export.ground", "max_extent_m", mesh::GroundPolygonOptions::kMaxExtent_m);
  fixed("export.gltf", "normal_bits", gltf::GltfOptions::kNormalBits);
  fixed("export.gltf", "crease_angle_deg", gltf::GltfOptions::kCreaseAngle_deg);
  fixed("export.gltf", "max_frustum_m", gltf::GltfOptions::kMaxFrustum_m);
}

}  // namespace deepslam::stages
