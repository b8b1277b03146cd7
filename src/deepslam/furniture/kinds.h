// The rules of each kind. They build in metres with the floor at z = 0 and the front at +x; where
// the origin lies on the floor is theirs to choose.
#pragma once

#include "deepslam/core/random.h"
#include "deepslam/furniture/solids.h"

namespace deepslam::furniture {

void BuildChair(Random& random, Solids& solids);
void BuildStool(Random& random, Solids& solids);
void BuildOfficeChair(Random& random, Solids& solids);
void BuildArmchair(Random& random, Solids& solids);
void BuildShellChair(Random& random, Solids& solids);
void BuildTable(Random& random, Solids& solids);
void BuildRoundTable(Random& random, Solids& solids);
void BuildDesk(Random& random, Solids& solids);
void BuildSofa(Random& random, Solids& solids);
void BuildCornerSofa(Random& random, Solids& solids);
void BuildSettee(Random& random, Solids& solids);
void BuildFramedSofa(Random& random, Solids& solids);
void BuildBed(Random& random, Solids& solids);
void BuildCabinet(Random& random, Solids& solids);
void BuildShelf(Random& random, Solids& solids);

}  // namespace deepslam::furniture
