// map.json, from which `deepslam expand` makes a scene.
#include "deepslam/artifact/map_json.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(map_json) { return RoundTrip(bytes, artifact::DecodeMap, artifact::EncodeMap); }
