!> The coupling of the ocean: its own arrays, once; they keep their place.
module gyre_coupling
  use gyre_model, only: model_type
  use insitu
  implicit none
  private

  public :: couple, show

contains

  !> ierr is that of the first call that fails; session%message() says why.
  subroutine couple(session, model, mesh, ierr)
    type(insitu_session), intent(in) :: session
    type(model_type), intent(in), target :: model
    type(insitu_mesh), intent(out) :: mesh
    integer, intent(out) :: ierr

    call session%mesh('ocean', mesh, ierr)
    associate (m => model%mesh)
      if (ierr == insitu_ok) call mesh%points(m%lon, m%lat, m%depth, ierr, frame='geodetic depth')
      if (ierr == insitu_ok) call mesh%wedges(m%connectivity, ierr)
      ! The levels without floor and air: a section, read where it is.
      if (ierr == insitu_ok) call mesh%cell_field('temperature', model%heat%t(:, 1:m%nlevels), ierr)
    end associate
    if (ierr == insitu_ok) call mesh%vertex_field('velocity', model%flow%velocity, ierr, vector=.true.)
  end subroutine couple

  !> What the scene asks for at this cycle.
  subroutine show(session, mesh, cycle, time, ierr)
    type(insitu_session), intent(in) :: session
    type(insitu_mesh), intent(in) :: mesh
    integer, intent(in) :: cycle
    real(kind=kind(1.0d0)), intent(in) :: time
    integer, intent(out) :: ierr

    call mesh%changed(insitu_fields)
    call session%execute(cycle, time, ierr)
  end subroutine show

end module gyre_coupling
