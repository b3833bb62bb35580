!> The coupling of the heat solver: its own arrays, once; they keep their place.
module heat_coupling
  use heat_solver, only: heat_type, nhalo
  use insitu
  implicit none
  private

  public :: couple

contains

  !> ierr is that of the first call that fails; session%message() says why.
  subroutine couple(session, model, mesh, ierr)
    type(insitu_session), intent(in) :: session
    type(heat_type), intent(in), target :: model
    type(insitu_mesh), intent(out) :: mesh
    integer, intent(out) :: ierr

    call session%mesh('ring', mesh, ierr)
    if (ierr == insitu_ok) call mesh%points(model%mesh%x, model%mesh%y, model%mesh%z, ierr)
    if (ierr == insitu_ok) call mesh%wedges(model%mesh%connectivity, ierr)
    ! The levels without their ghosts: a section, read where it is.
    if (ierr == insitu_ok) then
      call mesh%cell_field('temperature', model%t(:, 1 + nhalo:model%mesh%nlevels + nhalo), ierr)
    end if
    if (ierr == insitu_ok) call mesh%vertex_field('flux', model%flux, ierr, vector=.true.)
    if (ierr == insitu_ok) call mesh%global_cells(model%mesh%cell_ids, ierr)
    if (ierr == insitu_ok) call mesh%global_vertices(model%mesh%vertex_ids, ierr)
  end subroutine couple

end module heat_coupling
