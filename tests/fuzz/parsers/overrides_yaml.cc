// overrides.yaml of a workspace.
#include "deepslam/artifact/overrides_yaml.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(overrides_yaml) {
  const auto overrides = artifact::DecodeOverrides(bytes, kFile);
  if (!overrides.ok()) return Refused(overrides.error());
  (void)artifact::TrackOverridesText(*overrides);
  (void)artifact::ChoiceOverridesText(*overrides);
  (void)artifact::GroundOverridesText(*overrides);
  for (const auto* names : {&overrides->named, &overrides->named_choices}) {
    for (const NamedObject& name : *names)
      DEEPSLAM_CHECK(name.object.valid() && !name.class_name.empty(), "a name holds both");
  }
  if (overrides->ground)
    DEEPSLAM_CHECK(overrides->ground->up_camera.allFinite(), "the ground has a direction");
  return true;
}
