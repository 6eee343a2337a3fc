// Transfer of normal force, stored energy and friction from the patches of the previous contact
// search to those of a new one. docs/contact.md.
#pragma once

#include "solver/contact/patch_builder.h"

namespace firn {

// Transfers the state of the old patches of a pair to the new ones, and marks in
// scratch.has_parent the new patches with an old one. The state of an old patch is divided among
// its new patches in proportion to the energy that each can store. A new patch gets the sum over
// its old patches. Normal force and recoverable energy of the pair are continuous.
void transfer_history(const PatchInput& input, PatchScratch& scratch, PatchBuffer& out);

}  // namespace firn
