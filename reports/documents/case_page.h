// The page of a case before it runs: the scene in three dimensions, its prescribed motions, and the
// data of the case.
#pragma once

#include "experiments/case/case.h"
#include "reports/html/page.h"
#include "reports/replay/pose_tracks.h"

namespace firn {

// Poses over all stages without a simulation: every stage takes its longest duration, prescribed
// motions move frames and boundaries, free bodies stay where they start. `particles` come first
// (they do not move), then the boundaries of the case; a removed boundary is absent.
struct ScenePoses {
  struct Body {
    int shape = 0, tag = 0, batch = -1;
    Vec3 position = Vec3::Zero();         // m, center of mass, world
    Quat orientation = Quat::Identity();  // shape axes -> world
  };
  std::vector<Body> particles;
  PoseTracks tracks;
  struct StageStart {
    std::string name;
    double start = 0;  // s
  };
  std::vector<StageStart> stages;
  std::string problem;  // why particles of fills are missing; empty: they are complete
};

// Particles: those placed at the start, and the first batch of every fill and inlet (at most
// `most` of each), placed by the rules of a run.
ScenePoses scene_poses(const Case& c, int most = 1000);

// Throws InputError as scene_poses().
page::Page case_page(const Case& c);

}  // namespace firn
