// Motion of boundaries: prescribed motions, [[motion_frames]] and motors.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// Reads names, parents, motions and joints. Masses of free bodies are not set.
std::vector<MotionFrame> read_motion_frames(const TomlTable& root);
// Sets mass, center of mass and inertia of free bodies, from their keys or from the meshes of their
// boundaries. The model must have its boundaries.
void complete_free_bodies(const TomlTable& root, Model& model);

// Reads a prescribed motion or a motor. `also`: further keys that the caller reads.
Motion read_motion(const TomlTable& table, std::initializer_list<std::string_view> also = {});
Motor read_motor(const TomlTable& table, Joint::Kind kind,
                 std::initializer_list<std::string_view> also = {});

// Reads the coefficient of a friction that follows the load of a bearing. False, with the
// coefficient as it was: it is left out, and then the keys of the bearing are refused.
bool read_friction_coefficient(const TomlTable& table,
                               std::initializer_list<std::string_view> bearing_keys,
                               double& coefficient);

// Index of the frame that `key` names. Throws for an unknown name.
int frame_index(const TomlTable& table, std::string_view key,
                const std::vector<MotionFrame>& frames);
// The same; -1 without the key.
int optional_frame(const TomlTable& table, std::string_view key,
                   const std::vector<MotionFrame>& frames);

}  // namespace firn
