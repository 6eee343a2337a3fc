// Convex solids cut into pieces are the same solid again, however they were cut.
#include "solver/shapes/merge_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/dice.h"

namespace firn {
namespace {

// A convex solid of about unit size.
Piece random_solid(Dice& dice) {
  std::vector<Vec3> points;
  const int count = 5 + static_cast<int>(dice(0, 15));
  for (int i = 0; i < count; ++i) points.push_back(dice.vector(1));
  return convex_hull(points);
}

double piece_volume(const Piece& piece) {
  return mass_properties(surface_mesh(convex_part(piece, 0))).volume;
}

// Both sides of a cut; fewer where the plane misses the piece or leaves a sliver.
std::vector<Piece> cut(const Piece& piece, const HalfSpace& plane) {
  std::vector<Piece> sides;
  for (const double sign : {1.0, -1.0}) {
    Piece side = piece;
    side.push_back({sign * plane.normal, sign * plane.offset, false});
    try {
      if (piece_volume(side) > 1e-4) sides.push_back(std::move(side));
    } catch (const InputError&) {
    }
  }
  return sides.size() == 2 ? sides : std::vector<Piece>{piece};
}

std::vector<Piece> random_pieces(const Piece& solid, int planes, bool all, Dice& dice) {
  std::vector<Piece> pieces = {solid};
  for (int i = 0; i < planes; ++i) {
    const HalfSpace plane{dice.vector(1).normalized(), dice(-0.3, 0.3), false};
    std::vector<Piece> next;
    for (const Piece& p : pieces) {
      const bool is_cut = all || dice(0, 1) < 0.6;
      const std::vector<Piece> sides = is_cut ? cut(p, plane) : std::vector<Piece>{p};
      next.insert(next.end(), sides.begin(), sides.end());
    }
    pieces = std::move(next);
  }
  return pieces;
}

// Largest distance by which a corner of one is above a face of the other.
double difference(const Piece& a, const Piece& b) {
  double most = 0;
  for (const auto& [solid, faces] : {std::pair{&a, &b}, {&b, &a}}) {
    const ConvexPart part = convex_part(*solid, 0);
    for (const HalfSpace& h : *faces) {
      for (int i = 0; i < part.vertex_count; ++i)
        most = std::max(most, h.normal.dot(part.vertex(i)) - h.offset);
    }
  }
  return most;
}

TEST(MergePieces, AnyCutConvexSolidIsOnePieceAgain) {
  Dice dice(41);
  int cut_solids = 0;
  for (int i = 0; i < 200; ++i) {
    const Piece solid = random_solid(dice);
    const std::vector<Piece> pieces = random_pieces(solid, 1 + i % 5, i % 2 == 0, dice);
    cut_solids += pieces.size() > 1;
    const std::vector<Piece> merged = merge_convex_pieces(pieces);
    ASSERT_EQ(merged.size(), 1u) << "member " << i << " of " << pieces.size() << " pieces";
    EXPECT_LT(difference(merged[0], solid), 1e-5) << "member " << i;
  }
  EXPECT_GT(cut_solids, 150);
}

TEST(MergePieces, ConcaveSolidsKeepTheirVolumeAndNoPairThatFits) {
  Dice dice(43);
  for (int i = 0; i < 60; ++i) {
    // Two solids that share no face, and a third one on top of a face of the first.
    std::vector<Piece> pieces = random_pieces(random_solid(dice), 2, false, dice);
    for (Piece& p : random_pieces(random_solid(dice), 2, false, dice)) {
      for (HalfSpace& h : p) h.offset += h.normal.dot(Vec3(3, 0.5, 0.2));
      pieces.push_back(std::move(p));
    }
    double before = 0, after = 0;
    for (const Piece& p : pieces) before += piece_volume(p);
    const std::vector<Piece> merged = merge_convex_pieces(pieces);
    for (const Piece& p : merged) after += piece_volume(p);
    EXPECT_EQ(merged.size(), 2u) << "member " << i;
    EXPECT_NEAR(after, before, 1e-6 * before);
  }
}

Piece box(const Vec3& lower, const Vec3& upper) {
  Piece piece;
  for (int axis = 0; axis < 3; ++axis) {
    piece.push_back({Vec3::Unit(axis), upper[axis], false});
    piece.push_back({-Vec3::Unit(axis), -lower[axis], false});
  }
  return piece;
}

TEST(MergePieces, AnLBecomesTwoBoxesAndItsCutAnInternalFace) {
  std::vector<Piece> pieces = {box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1}),
                               box({0, 1, 0}, {1, 2, 1})};
  pieces = merge_convex_pieces(pieces);
  ASSERT_EQ(pieces.size(), 2u);
  mark_internal_faces(pieces, 3);
  int internal = 0;
  for (const Piece& p : pieces)
    internal += static_cast<int>(std::ranges::count_if(p, &HalfSpace::internal));
  // The box over two cells has a face that is covered in half: it stays surface.
  EXPECT_EQ(internal, 1);
}

TEST(MergePieces, SurfaceIsNotMergedWithInternalFaces) {
  std::vector<Piece> pieces = {box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1})};
  pieces[0][4].internal = true;  // +z
  EXPECT_EQ(merge_convex_pieces(pieces).size(), 2u);
  pieces[1][4].internal = true;
  EXPECT_EQ(merge_convex_pieces(pieces).size(), 1u);
}

TEST(MergePieces, PiecesApartOrOffsetStayAsTheyAre) {
  const Piece first = box({0, 0, 0}, {1, 1, 1});
  for (const Vec3& shift : {Vec3(1.01, 0, 0), Vec3(1, 0.01, 0), Vec3(1, 0, -0.2), Vec3(1, 1, 0)}) {
    EXPECT_EQ(merge_convex_pieces({first, box(shift, shift + Vec3::Ones())}).size(), 2u);
  }
}

}  // namespace
}  // namespace firn
