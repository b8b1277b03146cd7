#!/usr/bin/env python3
"""Camera poses by Open3D's reconstruction system, after its examples: fragments of 100 frames, their registration, and one
pose graph for each.

    V/bin/python scripts/open3d_reconstruction.py CAPTURE POSES.tum     # V as for scripts/compare_open3d.py, and
                                                                        # V/bin/pip install opencv-python-headless
Within a fragment each frame is aligned to the one before it, and every fifth to every other fifth where ORB corners find
a start; a fragment's cloud is that of its every fifth frame, averaged in voxels of 6 mm (the examples extract it from a
TSDF, which came out empty in Open3D 0.20.0); neighbours start from odometry, others from FPFH features by RANSAC, and all are
refined by coloured ICP on three scales. Options are those of the examples' default configuration, but for the largest
depth, which is deepslam's. CAPTURE as for compare_open3d.py. Prints times and counts as JSON.
"""
import argparse
import json
import pathlib
import resource
import time

from compare_open3d import MAX_DEPTH_M, quaternion, read_capture

PARSER = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
PARSER.add_argument("capture", type=pathlib.Path)
PARSER.add_argument("poses", type=pathlib.Path)
PARSER.add_argument("--seed", type=int, default=1, help="of its random draws, which move its poses by millimetres (default: 1)")
ARGUMENTS = PARSER.parse_args()  # before the imports, so that the help needs nothing installed

import cv2  # noqa: E402
import numpy as np  # noqa: E402
import open3d as o3d  # noqa: E402

FRAGMENT, KEYFRAME = 100, 5
MAX_DEPTH_DIFF_M, VOXEL_M = 0.07, 0.05
REGISTRATION = o3d.pipelines.registration


class Capture:
    def __init__(self, folder):
        self.number, self.frames = read_capture(folder)
        n = self.number
        self.camera = o3d.camera.PinholeCameraIntrinsic(int(n["width"]), int(n["height"]), n["fx"], n["fy"], n["cx"], n["cy"])

    def rgbd(self, index, intensity):
        colour, depth = (o3d.io.read_image(str(path)) for path in self.frames[index][1:])
        return o3d.geometry.RGBDImage.create_from_color_and_depth(
            colour, depth, depth_scale=self.number["depth_units_per_m"], depth_trunc=MAX_DEPTH_M,
            convert_rgb_to_intensity=intensity)


def corners(capture, rgbd):
    """ORB descriptors with their points in the camera's frame."""
    grey = np.clip(255 * np.asarray(rgbd.color), 0, 255).astype(np.uint8)
    depth = np.asarray(rgbd.depth)
    keypoints, descriptors = cv2.ORB_create(scaleFactor=1.2, nlevels=8, edgeThreshold=31, firstLevel=0, WTA_K=2,
                                            patchSize=31, nfeatures=500).detectAndCompute(grey, None)
    if descriptors is None:
        return np.zeros((0, 32), np.uint8), np.zeros((0, 3))
    n = capture.number
    pixels = np.array([k.pt for k in keypoints])
    z = depth[np.round(pixels[:, 1]).astype(int), np.round(pixels[:, 0]).astype(int)]
    points = np.stack([(pixels[:, 0] - n["cx"]) / n["fx"] * z, (pixels[:, 1] - n["cy"]) / n["fy"] * z, z], 1)
    return descriptors[z > 0], points[z > 0]


def rigid(a, b):
    """b_from_a of points, least squares (Umeyama)."""
    ma, mb = a.mean(0), b.mean(0)
    u, _, vt = np.linalg.svd((b - mb).T @ (a - ma))
    rotation = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, mb - rotation @ ma
    return pose


def start_by_corners(source, target, random, rounds=1000, near_m=0.05):
    """target_from_source by RANSAC over matched corners; None where fewer than ten agree."""
    if len(source[0]) < 10 or len(target[0]) < 10:
        return None
    matches = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(source[0], target[0])
    if len(matches) < 10:
        return None
    a = np.array([source[1][m.queryIdx] for m in matches])
    b = np.array([target[1][m.trainIdx] for m in matches])
    best = np.zeros(len(a), bool)
    for _ in range(rounds):
        some = random.choice(len(a), 5, replace=False)
        pose = rigid(a[some], b[some])
        near = np.linalg.norm(a @ pose[:3, :3].T + pose[:3, 3] - b, axis=1) < near_m
        if near.sum() > best.sum():
            best = near
    return rigid(a[best], b[best]) if best.sum() >= 10 else None


def optimize(graph, preference):
    option = REGISTRATION.GlobalOptimizationOption(max_correspondence_distance=MAX_DEPTH_DIFF_M, edge_prune_threshold=0.25,
                                                   preference_loop_closure=preference, reference_node=0)
    REGISTRATION.global_optimization(graph, REGISTRATION.GlobalOptimizationLevenbergMarquardt(),
                                     REGISTRATION.GlobalOptimizationConvergenceCriteria(), option)


def make_fragment(capture, begin, end, random):
    """Poses (fragment from camera) of its frames and its cloud."""
    images = [capture.rgbd(k, True) for k in range(begin, end)]
    keys = {k: corners(capture, images[k]) for k in range(0, end - begin, KEYFRAME)}
    option = o3d.pipelines.odometry.OdometryOption(depth_diff_max=MAX_DEPTH_DIFF_M, depth_max=MAX_DEPTH_M)
    hybrid = o3d.pipelines.odometry.RGBDOdometryJacobianFromHybridTerm()
    graph, odometry = REGISTRATION.PoseGraph(), np.eye(4)
    graph.nodes.append(REGISTRATION.PoseGraphNode(odometry))
    for s in range(end - begin):
        for t in range(s + 1, end - begin):
            if t == s + 1:
                start = np.eye(4)
            elif s in keys and t in keys:
                start = start_by_corners(keys[s], keys[t], random)
            else:
                continue
            ok, pose, information = (False, np.eye(4), np.eye(6)) if start is None else \
                o3d.pipelines.odometry.compute_rgbd_odometry(images[s], images[t], capture.camera, start, hybrid, option)
            if t == s + 1:
                odometry = pose @ odometry
                graph.nodes.append(REGISTRATION.PoseGraphNode(np.linalg.inv(odometry)))
                graph.edges.append(REGISTRATION.PoseGraphEdge(s, t, pose, information, uncertain=False))
            elif ok:
                graph.edges.append(REGISTRATION.PoseGraphEdge(s, t, pose, information, uncertain=True))
    optimize(graph, 0.1)
    poses, cloud = [node.pose for node in graph.nodes], o3d.geometry.PointCloud()
    for k in keys:
        seen = o3d.geometry.PointCloud.create_from_rgbd_image(capture.rgbd(begin + k, False), capture.camera)
        cloud += seen.transform(poses[k])
    return poses, cloud.voxel_down_sample(VOXEL_M / 8)


def coloured_icp(source, target, start):
    pose = start
    for voxel, rounds in zip((VOXEL_M, VOXEL_M / 2, VOXEL_M / 4), (50, 30, 14)):
        a, b = source.voxel_down_sample(voxel), target.voxel_down_sample(voxel)
        for cloud in (a, b):
            cloud.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=2 * voxel, max_nn=30))
        try:
            pose = REGISTRATION.registration_colored_icp(
                a, b, 1.4 * voxel, pose, REGISTRATION.TransformationEstimationForColoredICP(),
                REGISTRATION.ICPConvergenceCriteria(1e-6, 1e-6, rounds)).transformation
        except RuntimeError:  # no correspondences
            return None, None
    return pose, REGISTRATION.get_information_matrix_from_point_clouds(a, b, 1.4 * VOXEL_M / 4, pose)


def start_by_features(source, target):
    """By FPFH and RANSAC; None where it does not hold, by the examples' tests."""
    clouds = []
    for cloud in (source, target):
        down = cloud.voxel_down_sample(VOXEL_M)
        down.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=2 * VOXEL_M, max_nn=30))
        clouds.append((down, REGISTRATION.compute_fpfh_feature(
            down, o3d.geometry.KDTreeSearchParamHybrid(radius=5 * VOXEL_M, max_nn=100))))
    near = 1.4 * VOXEL_M
    found = REGISTRATION.registration_ransac_based_on_feature_matching(
        clouds[0][0], clouds[1][0], clouds[0][1], clouds[1][1], False, near,
        REGISTRATION.TransformationEstimationPointToPoint(False), 4,
        [REGISTRATION.CorrespondenceCheckerBasedOnEdgeLength(0.9), REGISTRATION.CorrespondenceCheckerBasedOnDistance(near)],
        REGISTRATION.RANSACConvergenceCriteria(1000000, 0.999))
    information = REGISTRATION.get_information_matrix_from_point_clouds(clouds[0][0], clouds[1][0], near, found.transformation)
    few = information[5, 5] / min(len(clouds[0][0].points), len(clouds[1][0].points)) < 0.3
    return None if few or np.trace(found.transformation) == 4 else found.transformation


def register_fragments(fragments):
    """World from fragment."""
    graph, odometry = REGISTRATION.PoseGraph(), np.eye(4)
    graph.nodes.append(REGISTRATION.PoseGraphNode(odometry))
    for s in range(len(fragments)):
        for t in range(s + 1, len(fragments)):
            following = t == s + 1
            start = np.linalg.inv(fragments[s][0][-1]) if following else start_by_features(fragments[s][1], fragments[t][1])
            if start is None:
                continue
            pose, information = coloured_icp(fragments[s][1], fragments[t][1], start)
            if pose is None and not following:
                continue
            pose, information = (start, np.eye(6)) if pose is None else (pose, information)
            if following:
                odometry = pose @ odometry
                graph.nodes.append(REGISTRATION.PoseGraphNode(np.linalg.inv(odometry)))
            graph.edges.append(REGISTRATION.PoseGraphEdge(s, t, pose, information, uncertain=not following))
    if len(fragments) > 1:
        optimize(graph, 5.0)
    return [node.pose for node in graph.nodes]


def main():
    args = ARGUMENTS
    begin_wall, begin = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF)
    o3d.utility.random.seed(args.seed)
    random, capture = np.random.default_rng(args.seed), Capture(args.capture)
    count = len(capture.frames)
    # As in the examples a fragment's last frame is the next one's first.
    fragments = [make_fragment(capture, k, min(count, k + FRAGMENT + 1), random) for k in range(0, max(1, count - 1), FRAGMENT)]
    world_from_fragment = register_fragments(fragments)
    with open(args.poses, "w") as file:
        for k, (stamp, _, _) in enumerate(capture.frames):
            n = min(k // FRAGMENT, len(fragments) - 1)
            pose = world_from_fragment[n] @ fragments[n][0][k - n * FRAGMENT]
            x, y, z, w = quaternion(np, pose[:3, :3])
            file.write(f"{stamp:.6f} {pose[0, 3]:.9f} {pose[1, 3]:.9f} {pose[2, 3]:.9f} {x:.9f} {y:.9f} {z:.9f} {w:.9f}\n")
    used = resource.getrusage(resource.RUSAGE_SELF)
    print(json.dumps({"wall_s": time.monotonic() - begin_wall, "fragments": len(fragments),
                      "cpu_s": used.ru_utime + used.ru_stime - begin.ru_utime - begin.ru_stime}))


if __name__ == "__main__":
    main()
