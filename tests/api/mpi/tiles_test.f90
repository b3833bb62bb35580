!> Tiles with halos on several processes: mpiexec -n 3. Answers are held against the fields' closed forms:
!! a cell's density is its own, the velocity is linear.
program tiles_test
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use insitu
  use mpi_f08
  use tiles
  implicit none

  character(len=*), parameter :: scene = &
      'insitu: 1' // new_line('a') // &
      'page: false' // new_line('a') // &
      'probes:' // new_line('a') // &
      '  - name: grid' // new_line('a') // &
      '    points: {grid: {min: [0.11, 0.13, 0.17], max: [4.3, 4.1, 4.9], counts: [8, 7, 6]}}' // new_line('a') // &
      '    fields: [density, velocity]' // new_line('a')
  !> What a coupling of several processes spoils first: particles that cross seams, a condition on all values, a frame.
  character(len=*), parameter :: more = &
      'tracers:' // new_line('a') // &
      '  - name: paths' // new_line('a') // &
      '    velocity: velocity' // new_line('a') // &
      '    kind: pathline' // new_line('a') // &
      '    output: [csv]' // new_line('a') // &
      '    seeds: {box: {min: [0.11, 0.13, 0.17], max: [4.3, 4.1, 4.9], counts: [10, 10, 10]}}' // new_line('a') // &
      'frames:' // new_line('a') // &
      '  - name: view' // new_line('a') // &
      '    when: max(density) > 29' // new_line('a') // &
      '    size: [48, 40]' // new_line('a') // &
      '    volume: {field: density}' // new_line('a')
  ! The grid again: none of its points is on a face.
  real(real64), parameter :: low(3) = [0.11_real64, 0.13_real64, 0.17_real64], high(3) = [4.3_real64, 4.1_real64, 4.9_real64]
  integer, parameter :: counts(3) = [8, 7, 6], steps = 3
  integer :: rank, processes, level, wrong, all_wrong

  call MPI_Init_thread(MPI_THREAD_FUNNELED, level)
  call MPI_Comm_rank(MPI_COMM_WORLD, rank)
  call MPI_Comm_size(MPI_COMM_WORLD, processes)
  wrong = 0
  call run(.false., 'plain')
  call run(.true., 'ghosts')
  is_uniform = .true.
  call run(.false., 'uniform')
  call run(.true., 'uniform_ghosts')
  call compare()
  call MPI_Allreduce(wrong, all_wrong, 1, MPI_INTEGER, MPI_SUM, MPI_COMM_WORLD)
  call MPI_Finalize()
  if (all_wrong > 0) error stop 1

contains

  subroutine run(with_ghosts, name)
    logical, intent(in) :: with_ghosts
    character(len=*), intent(in) :: name
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    type(tile_type), allocatable, target :: made(:)
    character(len=64) :: folder
    real(real64) :: time
    integer :: step, ierr

    write (folder, '(a, a, i0)') name, '_', rank
    call make_tiles(rank, chunks_of(processes), made)
    call session%open(ierr=ierr, scene_text=scene, output=trim(folder), strict=.true., &
                      communicator=MPI_COMM_WORLD%mpi_val)
    call expect('open ' // session%message(), ierr == insitu_ok)
    call session%mesh('box', mesh, ierr)
    call give_tiles(mesh, made, with_ghosts, ierr)
    call expect('tiles ' // session%message(), ierr == insitu_ok)
    do step = 0, steps
      time = 0.1_real64 * real(step, real64)
      if (step > 0) call move_on(made, time)
      call mesh%changed(insitu_fields)
      call session%execute(step, time, ierr)
      call expect('execute ' // session%message(), ierr == insitu_ok)
    end do
    call check_cells(mesh, made, time, with_ghosts)
    call check_everywhere(mesh, time)
    call session%close(ierr)
    call expect('close ' // session%message(), ierr == insitu_ok)
    call check_table(trim(folder) // '/grid.csv')
  end subroutine run

  !> The tiles of all processes in one process, and each in its own: the files are the same.
  subroutine compare()
    type(tile_type), allocatable, target :: made(:), all_made(:)
    character(len=*), parameter :: names(3) = [character(len=16) :: 'grid.csv', 'paths.csv', 'view_000002.png']
    character(len=*), parameter :: too_early = 'together/view_000001.png'
    integer :: r, n, unit

    if (rank == 0) then                                  ! as it may be there of a run before
      open (newunit=unit, file=too_early, status='old', iostat=n)
      if (n == 0) close (unit, status='delete')
    end if
    call make_tiles(rank, chunks_of(processes), made)
    call couple(made, MPI_COMM_WORLD, 'together')
    if (rank > 0) return
    do r = 0, processes - 1
      call make_tiles(r, chunks_of(processes), made)
      if (r == 0) all_made = made(:0)
      all_made = [all_made, made]
    end do
    call couple(all_made, MPI_COMM_SELF, 'alone')
    do n = 1, size(names)
      call expect(trim(names(n)) // ' of several processes', are_same('together/' // trim(names(n)), 'alone/' // trim(names(n))))
    end do
    ! Some leave the box, most of them at its end.
    call expect('1000 particles', lines_of('together/paths.csv') > 3000)
    call expect('no frame before', .not. exists(too_early))
  end subroutine compare

  subroutine couple(made, communicator, folder)
    type(tile_type), intent(inout), target :: made(:)
    type(MPI_Comm), intent(in) :: communicator
    character(len=*), intent(in) :: folder
    type(insitu_session) :: session
    type(insitu_mesh) :: mesh
    integer :: step, ierr

    call session%open(ierr=ierr, scene_text=scene // more, output=folder, strict=.true., communicator=communicator%mpi_val)
    call expect('open ' // session%message(), ierr == insitu_ok)
    call session%mesh('box', mesh, ierr)
    call give_tiles(mesh, made, .true., ierr)
    do step = 0, steps
      if (step > 0) call move_on(made, 0.1_real64 * real(step, real64))
      call mesh%changed(insitu_fields)
      call session%execute(step, 0.1_real64 * real(step, real64), ierr)
      call expect('execute ' // session%message(), ierr == insitu_ok)
    end do
    call session%close(ierr)
    call expect('close ' // session%message(), ierr == insitu_ok)
  end subroutine couple

  logical function exists(name)
    character(len=*), intent(in) :: name
    inquire (file=name, exist=exists)
  end function exists

  !> All bytes of a file.
  function bytes_of(name) result(bytes)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: bytes
    integer :: unit, length, status

    bytes = ''
    open (newunit=unit, file=name, access='stream', form='unformatted', status='old', action='read', iostat=status)
    call expect('opening ' // name, status == 0)
    if (status /= 0) return
    inquire (unit=unit, size=length)
    deallocate (bytes)
    allocate (character(len=length) :: bytes)
    read (unit) bytes
    close (unit)
  end function bytes_of

  logical function are_same(a, b)
    character(len=*), intent(in) :: a, b
    character(len=:), allocatable :: one, other

    one = bytes_of(a)
    other = bytes_of(b)
    are_same = len(one) == len(other) .and. len(one) > 0 .and. one == other
  end function are_same

  integer function lines_of(name)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: bytes
    integer :: i

    bytes = bytes_of(name)
    lines_of = count([(bytes(i:i) == new_line('a'), i=1, len(bytes))])
  end function lines_of

  !> Along x and y.
  pure function chunks_of(processes) result(chunks)
    integer, intent(in) :: processes
    integer :: chunks(2)

    chunks(1) = int(sqrt(real(processes)))
    do while (modulo(processes, chunks(1)) /= 0)
      chunks(1) = chunks(1) - 1
    end do
    chunks(2) = processes / chunks(1)
  end function chunks_of

  !> The process's own queries: it finds the middle of each of its cells in its own tile, by its own number,
  !! and no other cell of the box.
  subroutine check_cells(mesh, made, time, with_ghosts)
    type(insitu_mesh), intent(in) :: mesh
    type(tile_type), intent(in) :: made(:)
    real(real64), intent(in) :: time
    logical, intent(in) :: with_ghosts
    real(real64) :: x(1), y(1), z(1), value(1)
    integer(int64) :: cell(1)
    integer :: i, j, k, t, piece(1), owner, first(3), size_of(3), ierr, owners, everywhere
    logical :: found(1)

    owners = 0
    do k = 0, cells(3) - 1
      do j = 0, cells(2) - 1
        do i = 0, cells(1) - 1
          owner = 0
          do t = 1, size(made)
            if (all([i, j, k] >= made(t)%first .and. [i, j, k] <= made(t)%last)) owner = t
          end do
          x = middle(i, 1)
          y = middle(j, 2)
          z = middle(k, 3)
          call mesh%locate(x, y, z, cell, ierr, found=found, pieces=piece)
          call expect('locate', ierr == insitu_ok .and. (found(1) .eqv. owner > 0))
          if (owner == 0) cycle
          owners = owners + 1
          first = made(owner)%first - merge(halo, 0, with_ghosts)
          size_of = made(owner)%last - made(owner)%first + 1 + merge(2 * halo, 0, with_ghosts)
          call expect('piece', piece(1) == owner)
          call expect('cell', cell(1) == 1 + i - first(1) + size_of(1) * (j - first(2) + size_of(2) * (k - first(3))))
          call mesh%sample('density', x, y, z, value, ierr)
          call expect('density', ierr == insitu_ok .and. abs(value(1) - density_at(i, j, k, time)) <= 0.0_real64)
        end do
      end do
    end do
    call MPI_Allreduce(owners, everywhere, 1, MPI_INTEGER, MPI_SUM, MPI_COMM_WORLD)
    call expect('each cell is found once', everywhere == product(cells))
  end subroutine check_cells

  !> Queries of all processes: the middle of every cell is found by its owner's rank, every vertex by the lowest
  !! of the processes around it, whoever asks.
  subroutine check_everywhere(mesh, time)
    type(insitu_mesh), intent(in) :: mesh
    real(real64), intent(in) :: time
    real(real64) :: at(3, all_cells), vertices(3, all_vertices), density(all_cells)
    real(real64) :: velocity(3, all_vertices), right(all_cells)
    real(real64) :: distances(all_cells), apart(2, all_vertices)
    integer(int64) :: found_cells(all_cells), found_vertices(all_vertices), nearest(2, all_vertices)
    integer :: ranks(all_cells), owners(all_cells), ranks_there(all_vertices), firsts(all_vertices)
    integer :: i, j, k, n, v, ierr

    n = 0
    v = 0
    do k = 0, cells(3)
      do j = 0, cells(2)
        do i = 0, cells(1)
          v = v + 1
          vertices(:, v) = [plane(i, 1), plane(j, 2), plane(k, 3)]
          firsts(v) = first_of([i, j, k] - 1, [i, j, k], chunks_of(processes))
          if (any([i, j, k] == cells)) cycle
          n = n + 1
          at(:, n) = [middle(i, 1), middle(j, 2), middle(k, 3)]
          owners(n) = first_of([i, j, k], [i, j, k], chunks_of(processes))
          right(n) = density_at(i, j, k, time)
        end do
      end do
    end do
    call mesh%locate(at, found_cells, ierr, everywhere=.true., ranks=ranks)
    call expect('cells everywhere ' // insitu_status_name(ierr), ierr == insitu_ok .and. all(ranks == owners))
    call mesh%sample('density', at, density, ierr, everywhere=.true.)
    call expect('density everywhere', ierr == insitu_ok .and. all(abs(density - right) <= 0.0_real64))
    call mesh%locate(vertices, found_vertices, ierr, everywhere=.true., ranks=ranks_there)
    call expect('vertices everywhere', ierr == insitu_ok .and. all(ranks_there == firsts))
    call mesh%sample('velocity', vertices, velocity, ierr, everywhere=.true.)
    call expect('velocity everywhere', ierr == insitu_ok)
    do v = 1, size(vertices, 2)
      call expect('velocity at a vertex', all(abs(velocity(:, v) - velocity_at(vertices(:, v))) < 1.0e-13_real64))
    end do
    ! Below the box: the cells of the lowest layer by their distance, and too far away none.
    n = cells(1) * cells(2)
    at(3, :n) = -0.125_real64
    at(3, 1) = -2.0_real64
    call mesh%locate(at(:, :n), found_cells(:n), ierr, everywhere=.true., ranks=ranks(:n), &
                     distances=distances(:n), greatest_distance=1.0_real64)
    call expect('the nearest cells ' // insitu_status_name(ierr), ierr == insitu_ok)
    call expect('their processes', all(ranks(2:n) == owners(2:n)) .and. ranks(1) == -1)
    call expect('their distances', all(abs(distances(2:n) - 0.125_real64) < 1.0e-13_real64))
    call expect('no distance to what is too far away', ieee_is_nan(distances(1)))
    call mesh%nearest_vertices(vertices, nearest, ierr, everywhere=.true., distances=apart)
    call expect('the nearest vertices ' // insitu_status_name(ierr), ierr == insitu_ok)
    call expect('at no distance', all(abs(apart(1, :)) < 1.0e-13_real64))
    call expect('in order', all(apart(2, :) >= apart(1, :) .and. apart(2, :) < 1.0_real64))
  end subroutine check_everywhere

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (holds) return
    wrong = wrong + 1
    if (wrong <= 5) write (error_unit, '(a, i0, 2a)') 'process ', rank, ' failed: ', what
  end subroutine expect

  !> Every point of the grid is found once a cycle, by whoever has its cell, with the values there.
  subroutine check_table(name)
    character(len=*), intent(in) :: name
    character(len=1024) :: header, row
    integer :: unit, status, rows, everywhere

    rows = 0
    open (newunit=unit, file=name, status='old', action='read', iostat=status)
    if (status == 0) then
      read (unit, '(a)') header
      do
        read (unit, '(a)', iostat=status) row
        if (status /= 0) exit
        if (entry(header, row, 'density') == '') cycle   ! outside of what this process has
        rows = rows + 1
        call check_row(header, row)
      end do
      close (unit)
    end if
    call MPI_Allreduce(rows, everywhere, 1, MPI_INTEGER, MPI_SUM, MPI_COMM_WORLD)
    call expect('each point of the grid is found once a cycle', everywhere == (steps + 1) * product(counts))
  end subroutine check_table

  subroutine check_row(header, row)
    character(len=*), intent(in) :: header, row
    real(real64) :: at(3), velocity(3)
    integer :: n, cell(3)

    n = nint(number(header, row, 'point'))
    at = low + (high - low) * real([modulo(n, counts(1)), modulo(n / counts(1), counts(2)), n / (counts(1) * counts(2))], &
                                   real64) / real(counts - 1, real64)
    cell = cell_of(at)
    call expect('the point is on no face', all(cell >= 0))
    call expect('density of the table', abs(number(header, row, 'density') &
        - density_at(cell(1), cell(2), cell(3), number(header, row, 'time'))) <= 0.0_real64)
    velocity = [number(header, row, 'velocity_x'), number(header, row, 'velocity_y'), number(header, row, 'velocity_z')]
    ! Some roundings of numbers of at most 10.
    call expect('velocity of the table', all(abs(velocity - velocity_at(at)) < 1.0e-13_real64))
  end subroutine check_row

  !> What stands in the column of that name.
  pure function entry(header, row, name) result(text)
    character(len=*), intent(in) :: header, row, name
    character(len=64) :: text
    integer :: column

    column = 1
    do while (part(header, column) /= name)
      column = column + 1
    end do
    text = part(row, column)
  end function entry

  real(real64) function number(header, row, name)
    character(len=*), intent(in) :: header, row, name
    character(len=64) :: text

    text = entry(header, row, name)
    read (text, *) number
  end function number

  !> Of a list with commas, the n-th.
  pure function part(list, n) result(text)
    character(len=*), intent(in) :: list
    integer, intent(in) :: n
    character(len=64) :: text
    integer :: i, begin, length

    begin = 1
    do i = 1, n
      length = index(list(begin:), ',') - 1
      if (length < 0) length = len_trim(list(begin:))
      text = list(begin:begin + length - 1)
      begin = min(begin + length + 1, len(list))
    end do
  end function part

end program tiles_test
