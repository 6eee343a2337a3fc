// How boundaries of a case move: motions, [[motion_frames]] and motors.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// Names of frames, parents, motions and axes; free bodies without mass yet.
std::vector<MotionFrame> read_motion_frames(const TomlTable& root);
// Mass, centre and inertia of the free ones, from what they say or from the meshes they carry.
// Boundaries have been read.
void complete_free_bodies(const TomlTable& root, Model& model);

// Keys of a prescribed motion. `also`: further keys, which the caller reads.
Motion read_motion(const TomlTable& table, std::initializer_list<std::string_view> also = {});
Motor read_motor(const TomlTable& table, Joint::Kind kind,
                 std::initializer_list<std::string_view> also = {});

// The index of the frame that `key` names. Throws for an unknown one.
int frame_index(const TomlTable& table, std::string_view key,
                const std::vector<MotionFrame>& frames);
// -1 without the key.
int optional_frame(const TomlTable& table, std::string_view key,
                   const std::vector<MotionFrame>& frames);

}  // namespace firn
