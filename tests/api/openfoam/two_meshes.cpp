// Moves the meshes of two regions, each in a step of its own, as a solver of OpenFOAM's would: the
// plate by a cell, the air by two. A field of each has the numbers of its cells.
#include <Time.H>
#include <argList.H>
#include <fvMesh.H>
#include <volFields.H>

namespace {

using namespace Foam;

constexpr double width_of_cell = 0.005;

volScalarField numbers_of_cells(const fvMesh& mesh) {
  volScalarField number(IOobject("number", mesh.time().timeName(), mesh), mesh,
                        dimensionedScalar("0", dimless, 0));
  forAll(number, cell) number[cell] = cell;
  return number;
}

void move(fvMesh& mesh, label cells) {
  mesh.movePoints(pointField(mesh.points() + vector(cells * width_of_cell, 0, 0)));
}

} // namespace

int main(int argc, char* argv[]) {
  argList args(argc, argv);
  Time time(Time::controlDictName, args);
  fvMesh air(IOobject("air", time.timeName(), time, IOobject::MUST_READ));
  fvMesh plate(IOobject("plate", time.timeName(), time, IOobject::MUST_READ));
  const volScalarField of_air = numbers_of_cells(air), of_plate = numbers_of_cells(plate);
  while (time.loop()) {
    if (time.timeIndex() == 2)
      move(plate, 1);
    if (time.timeIndex() == 3)
      move(air, 2);
  }
}
