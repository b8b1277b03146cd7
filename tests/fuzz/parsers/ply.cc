// Meshes as they lie in a workspace.
#include "deepslam/artifact/ply.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(ply) { return RoundTrip(bytes, artifact::DecodePly, artifact::EncodePly); }
