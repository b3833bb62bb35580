!> All that the ocean knows of libinsitu: its own arrays are given once, and keep their place.
module gyre_coupling
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit, real64
  use gyre_model, only: model_type
  use insitu
  implicit none
  private

  type, public :: coupling_type
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    logical :: works = .false.                           !< if not, the solver runs on alone
    logical :: is_root = .true.                          !< who prints, of several processes
  contains
    procedure :: begin, show, finish
  end type coupling_type

contains

  subroutine begin(self, model, scene, output, threads)
    class(coupling_type), intent(inout) :: self
    type(model_type), intent(in), target :: model
    character(len=*), intent(in) :: scene, output
    integer, intent(in) :: threads
    integer :: ierr
    associate (m => model%mesh, mesh => self%mesh)
      call self%session%open(scene=scene, output=output, threads=threads, communicator=m%processes%communicator, ierr=ierr)
      if (ierr == insitu_ok) call self%session%mesh('ocean', mesh, ierr)
      if (ierr == insitu_ok) call mesh%points(m%lon, m%lat, m%depth, ierr, frame='geodetic depth')
      if (ierr == insitu_ok) call mesh%wedges(m%connectivity, ierr)
      if (ierr == insitu_ok) call mesh%cell_field('temperature', &
          model%heat%t(m%first_column:m%last_column, 1:m%nlevels), ierr) ! a section
      if (ierr == insitu_ok) call mesh%vertex_field('velocity', model%flow%velocity, ierr, vector=.true.)
      if (ierr == insitu_ok) call mesh%global_cells(m%cell_ids, ierr)
      if (ierr == insitu_ok) call mesh%global_vertices(m%vertex_ids, ierr)
      self%works = ierr == insitu_ok
      self%is_root = m%processes%is_root()
    end associate
    if (self%is_root .and. .not. self%works) write (error_unit, '(2a)') 'gyre: not coupled: ', self%session%message()
  end subroutine begin

  subroutine show(self, cycle, time)
    class(coupling_type), intent(inout) :: self
    integer, intent(in) :: cycle
    real(real64), intent(in) :: time
    integer :: ierr
    if (.not. self%works) return
    call self%mesh%changed(insitu_fields)
    call self%session%execute(cycle, time, ierr)         ! a part that fails is told by the library's log
  end subroutine show

  subroutine finish(self, output, solver_s)
    class(coupling_type), intent(inout) :: self
    character(len=*), intent(in) :: output
    real(real64), intent(in) :: solver_s
    type(insitu_report) :: report
    integer :: ierr
    call self%session%report(report, ierr)
    if (self%is_root) write (output_unit, '(6(i0, a))') report%frames, ' frames, ', report%probe_rows, ' probe rows, ', &
        report%particles_seeded, ' particles, ', report%failures, ' failures, ', report%bytes_held, ' bytes held'
    if (output /= '') call self%session%write_summary(trim(output) // '/summary.json', ierr, solver_s=solver_s)
    call self%session%close(ierr)
  end subroutine finish
end module gyre_coupling
